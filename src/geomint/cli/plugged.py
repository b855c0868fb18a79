"""What a command of another package does, without importing it."""

import ast
from importlib.util import find_spec
from pathlib import Path


def summary(module: str, function: str = "") -> str:
    """Return the first line of a function's docstring, read from the source of its module.

    Of the packages around nothing is imported either. Where there is no such text, the package's name.
    """
    package = module.partition(".")[0]
    try:
        tree = ast.parse(_source(module).read_text(encoding="utf-8"))
    except (Exception, SystemExit):  # whatever is wrong with it
        return f"From {package}."
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name == function:
            lines = (ast.get_docstring(node) or "").splitlines()
            if lines:
                return lines[0]
    return f"From {package}."


def _source(module: str) -> Path:
    """Return the file of a module; only the top of the package is looked for by Python."""
    package, *parts = module.split(".")
    spec = find_spec(package)
    if spec is None:
        raise ImportError(package)
    if not parts:
        return Path(spec.origin or "")
    folder = Path(next(iter(spec.submodule_search_locations or [""])))
    path = folder.joinpath(*parts)
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
