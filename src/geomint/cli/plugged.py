"""What a command of another package does, without importing it."""

import ast
from importlib.util import find_spec
from pathlib import Path


def summary(module: str, function: str = "") -> str:
    """Return the first line of a function's docstring, or its module's, read from the source.

    Of the packages around nothing is imported either. Where there is no such text, the package's name.
    """
    package = module.partition(".")[0]
    try:
        tree = ast.parse(_source(module).read_text(encoding="utf-8"))
    except (Exception, SystemExit):  # whatever is wrong with it
        return f"From {package}."
    functions = [n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == function]
    nodes: list[ast.FunctionDef | ast.Module] = [*functions, tree]
    texts = (ast.get_docstring(node) for node in nodes)
    return next((text.splitlines()[0] for text in texts if text), f"From {package}.")


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
