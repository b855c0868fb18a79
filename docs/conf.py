"""Sphinx configuration. The build needs no network and runs with warnings as errors."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any

# Autodoc imports the package: without a display, and from this tree if it is not installed.
os.environ.setdefault("MPLBACKEND", "Agg")
sys.path.insert(0, str(Path(__file__).parents[1] / "src"))
sys.path.insert(0, str(Path(__file__).parent))

import tables
from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from public_names import documented_as, with_public_names

import geomint

project = "geomint"
author = "The geomint authors"
copyright = "The geomint authors"
version = release = geomint.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
# The tables are included by pages.
exclude_patterns = [
    "_build",
    "examples",
    "audit-table.md",
    "drift-classes-table.md",
    "stress-table.md",
]
default_role = "py:obj"

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "substitution"]
myst_heading_anchors = 3

autodoc_default_options = {"members": True, "exclude-members": "model_config"}
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
# Types are words, such as "array, shape (n,)", not references.
napoleon_use_param = False
napoleon_use_rtype = False
# Several attributes may share one line of an Attributes section.
napoleon_custom_sections = [("Attributes", "params_style")]

myst_substitutions = tables.substitutions()

# The gallery: docs/examples is run, and docs/gallery is what comes out.
sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "example_extensions": {".py"},
    "within_subsection_order": "gallery_setup.PageOrder",
    "abort_on_example_error": True,
    "reset_modules": ("gallery_setup.begin_page",),
    "image_scrapers": ("gallery_setup.new_figures",),
    "capture_repr": (),
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "plot_gallery": "True",
}

html_theme = "furo"
html_title = f"geomint {release}"
html_static_path = ["_static"]
html_css_files = ["geomint.css"]
html_show_sphinx = False
html_copy_source = False
html_math_renderer = "mathml"
pygments_style = "tango"

_LITERAL = re.compile(r"(``.*?``)")
_BAR = re.compile(r"(?<!\\)\|")
_PLAIN_NAME = re.compile(r"(?<![`:\w])`([a-z_][a-z0-9_]*)`(?!`)")


def _as_rst(lines: list[str]) -> list[str]:
    """Escape the bars of norms, |γ|, and show simple names in single backticks as code.

    To reStructuredText |γ| is a substitution, and `n` a reference to any object of that name.
    Literal blocks and examples stay as they are.
    """
    result, indent = [], None
    for line in lines:
        depth = len(line) - len(line.lstrip())
        if indent is not None and line.strip() and depth <= indent:
            indent = None
        if indent is None and not line.lstrip().startswith((">>>", "...")):
            parts = _LITERAL.split(line)
            parts[::2] = [_PLAIN_NAME.sub(r"``\1``", _BAR.sub(r"\|", p)) for p in parts[::2]]
            if line.rstrip().endswith("::"):
                indent = depth
            line = "".join(parts)
        result.append(line)
    return result


_COLON = "\ue000"  # hides colons from napoleon, to which a property's "a: b" gives a type


def _before(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = _as_rst(lines)
    if what in ("property", "attribute"):
        lines[:] = [line.replace(":", _COLON) for line in lines]


def _after(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = [line.replace(_COLON, ":") for line in lines]


# What the converter does not know, or takes otherwise than TeX does.
_TEX = (
    (re.compile(r"\\[bB]igg?[lr]?(?![a-z])"), ""),
    (re.compile(r"\\[td]?frac\s*(\d)(\d)"), r"\\frac{\1}{\2}"),
    (re.compile(r"\\(hat|dot|tilde|bar)\s*(\\[A-Za-z]+|[A-Za-z])"), r"{\\\1{\2}}"),
)


def _mathml(block: bool) -> Any:
    """Return a visitor that writes MathML, which browsers show without a script or a network."""

    def visit(translator: Any, node: Any) -> None:
        text = node.astext()
        for pattern, replacement in _TEX:
            text = pattern.sub(replacement, text)
        if block and "\\\\" in text:
            text = rf"\begin{{aligned}}{text}\end{{aligned}}"
        translator.body.append(tex2mathml(text, as_block=block))
        raise nodes.SkipNode

    return visit


def _public_name(app: Any, env: Any, node: Any, text: Any) -> Any:
    """Resolve the name of something public to its public name, under which it is documented."""
    target = documented_as(node.get("reftarget", ""), node.get("py:module"))
    if target is None:
        return None
    domain = env.get_domain("py")
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", target, node, text)


def _expanded(app: Any, name: str, content: list[str]) -> None:
    text = tables.with_modules(content[0])
    content[0] = with_public_names(text) if name.startswith("api/") else text


def setup(app: Any) -> None:
    """Connect before and after napoleon, which has priority 500."""
    app.connect("source-read", _expanded)
    app.connect("missing-reference", _public_name)
    app.add_html_math_renderer("mathml", (_mathml(False), None), (_mathml(True), None))
    app.connect("autodoc-process-docstring", _before, priority=400)
    app.connect("autodoc-process-docstring", _after, priority=600)
