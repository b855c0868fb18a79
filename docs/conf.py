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

import geomint

project = "geomint"
author = "The geomint authors"
copyright = "The geomint authors"  # noqa: A001 - the name that Sphinx wants
version = release = geomint.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_design",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build"]
default_role = "py:obj"

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3

autodoc_default_options = {"members": True, "show-inheritance": False}
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
# Types are words, such as "array, shape (n,)", not references.
napoleon_use_param = False
napoleon_use_rtype = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"geomint {release}"
html_static_path = ["_static"]
html_css_files = ["geomint.css"]
html_show_sphinx = False
html_copy_source = False
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


def _process(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = _as_rst(lines)


def setup(app: Any) -> None:
    """Connect before napoleon, which has priority 500."""
    app.connect("autodoc-process-docstring", _process, priority=400)
