"""Sphinx configuration. The build needs no network and runs with warnings as errors."""

from __future__ import annotations

import importlib
import json
import os
import re
import sys
from pathlib import Path
from typing import Any

# Autodoc imports the package: without a display, and from this tree if it is not installed.
os.environ.setdefault("MPLBACKEND", "Agg")
sys.path.insert(0, str(Path(__file__).parents[1] / "src"))

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

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
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
# The tables are included by pages.
exclude_patterns = ["_build", "audit-table.md", "drift-classes-table.md"]
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

_ROOT = Path(__file__).parents[1]


def _benchmark() -> str:
    """Return the table of the benchmark's own result, so that the page cannot differ from it."""
    path = _ROOT / "benchmarks" / "results" / "hamiltonized_n3.json"
    result = json.loads(path.read_text(encoding="utf-8"))
    versions = result["machine"]["versions"]
    lines = [
        f"| error | geomint {versions['geomint']} (ms) | heyoka {versions['heyoka']} (ms) | ratio |",
        "|---|---|---|---|",
    ]
    for error, row in result["at_error"].items():
        ours, theirs = row["geomint_ms"], row["heyoka_ms"]
        lines.append(
            f"| {float(error):g} | {ours:.1f} | {theirs:.1f} | {row['heyoka_over_geomint']:.1f} |"
        )
    return "\n".join(lines)


_KINDS = {
    "energy": "energy",
    "integrals": "other integrals",
    "constraints": "constraints",
    "measure": "measure",
}


def _drift_tables() -> dict[str, str]:
    """Return a table for each scene of the benchmark of drifts: largest deviation, worst class."""
    path = _ROOT / "benchmarks" / "results" / "drift_by_method.json"
    scenes = json.loads(path.read_text(encoding="utf-8"))["scenes"]
    return {f"drift_{name.replace('-', '_')}": _drift_table(s) for name, s in scenes.items()}


def _drift_table(scene: dict[str, Any]) -> str:
    heads = ["method", "representation", "step", "µs a step", *_KINDS.values()]
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for label, method in scene["methods"].items():
        run = method["run"]
        if run is None:
            lines.append(f"| `{label}` | {method['status']}: {method['message']} |" + " |" * 6)
            continue
        time = {"t": "t", "tau": "τ"}[run["time"]]
        each = 1e6 * run["run_seconds"] / max(run["steps"], 1)
        cells = [f"`{label}`", method["representation"], f"{run['step']:.3g} in {time}"]
        cells += [f"{each:.2g}", *(_drift_cell(scene, method, kind) for kind in _KINDS)]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _drift_cell(scene: dict[str, Any], method: dict[str, Any], kind: str) -> str:
    """Return the largest deviation / scale (of the measure: the deviation) and its class."""
    found = [q for name, q in method["quantities"].items() if scene["kinds"][name] == kind]
    sizes = [(q["max_abs_error"] / (q["scale"] if kind != "measure" else 1.0), q) for q in found]
    if not sizes:
        return "–"
    size, worst = max(sizes, key=lambda pair: pair[0])
    return f"{size:.1e} `{worst['class']}`"


myst_substitutions = {"benchmark": _benchmark(), **_drift_tables()}

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
    """Resolve a public name, such as geomint.Problem, to where it is defined and documented."""
    package, _, name = node.get("reftarget", "").partition(".")
    if package not in ("geomint", "chaplygin") or not name:
        return None
    value = getattr(importlib.import_module(package), name.split(".")[0], None)
    module = getattr(value, "__module__", None)
    if module is None or module == package:
        return None
    domain = env.get_domain("py")
    target = f"{module}.{name}"
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", target, node, text)


def setup(app: Any) -> None:
    """Connect before and after napoleon, which has priority 500."""
    app.connect("missing-reference", _public_name)
    app.add_html_math_renderer("mathml", (_mathml(False), None), (_mathml(True), None))
    app.connect("autodoc-process-docstring", _before, priority=400)
    app.connect("autodoc-process-docstring", _after, priority=600)
