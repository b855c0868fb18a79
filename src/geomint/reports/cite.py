"""What to cite: the sources of a system and of a method, and the package."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any

from .. import __version__
from ..errors import DomainError, MethodError
from ..methods.method import Method
from ..methods.registry import find_solver
from ..problems.problem import Problem
from ..references.literature import GEOMINT
from ..references.reference import Reference
from ..run.result import Result
from ..scene import Scene, load_scene

__all__ = ["Citation", "cite"]


@dataclass(frozen=True, repr=False)
class Citation:
    """What to cite, as text and as BibTeX: ``print(citation)`` shows the first.

    Attributes
    ----------
    parts : tuple of (what, references)
        A heading, such as ``"method gauss-8"``, and its sources, the original one first.

    Examples
    --------
    >>> import geomint as gi
    >>> isinstance(gi.cite("gauss-8"), gi.Citation)
    True
    """

    parts: tuple[tuple[str, tuple[Reference, ...]], ...]

    @property
    def references(self) -> tuple[Reference, ...]:
        """All sources, each once."""
        found = {one.key: one for _, references in self.parts for one in references}
        return tuple(found.values())

    @property
    def text(self) -> str:
        """Headings, and below each its sources."""
        lines = []
        for heading, references in self.parts:
            lines += [f"{heading}:", *(f"  {one.text}" for one in references)]
            lines += [] if references else ["  no source is stated"]
        return "\n".join(lines) + "\n"

    @property
    def bibtex(self) -> str:
        """The entries of all sources, for a file ``.bib``, in ASCII."""
        return "\n".join(one.bibtex for one in self.references)

    def keys(self, beginning: str) -> str:
        """Return the keys of the parts whose headings begin so, with commas between."""
        keys = (r.key for what, ones in self.parts if what.startswith(beginning) for r in ones)
        return ",".join(dict.fromkeys(keys))

    def __str__(self) -> str:
        return self.text.rstrip("\n")

    def __repr__(self) -> str:
        return f"<citation: {', '.join(one.key for one in self.references)}>"


def cite(*what: Any) -> Citation:
    """Return what to cite for a result: the sources of system and method, and the package.

    Parameters
    ----------
    *what : Solution, Section, Scene, Problem, Method or str
        Anything with a `problem` and a `method`, or one of them; the name of a method or of a scene, or
        the path of one. None gives the package alone.

    Returns
    -------
    Citation
        With `text`, `bibtex` and `references`.

    Raises
    ------
    DomainError
        For something else.
    SceneError
        If a text is the name of neither a method nor a scene.
    MissingCodeError
        Of a loaded result whose problem is not made by its name: nothing is unpickled here.

    Examples
    --------
    >>> import geomint as gi
    >>> gi.cite("cf-4")
    <citation: CelledoniMarthinsenOwren2003, geomint>
    >>> gi.cite("ball-3d").keys("system")
    'Chaplygin2002,Jovanovic2010'
    """
    parts: dict[str, tuple[Reference, ...]] = {}
    for one in what:
        parts |= dict(_parts(one))
    parts["software"] = (replace(GEOMINT, note=f"Version {__version__}"),)
    return Citation(tuple(parts.items()))


def _parts(one: Any) -> Iterator[tuple[str, tuple[Reference, ...]]]:
    """Yield headings and sources of one thing."""
    if isinstance(one, str):
        one = _named(one)
    elif isinstance(one, PathLike):
        one = load_scene(one)
    if isinstance(one, Result):
        one.code("about"), one.code("by")  # else they might be unpickled below
    problem = one if isinstance(one, Problem) else getattr(one, "problem", None)
    method = one if isinstance(one, Method) else getattr(one, "method", None)
    known = isinstance(problem, Problem), isinstance(method, Method)
    if not any(known):
        expected = "a result, a scene, a problem, a method, or the name of a scene or method"
        raise DomainError("what", one, expected)
    if isinstance(problem, Problem):
        yield f"system {problem.name}", problem.references
    if isinstance(method, Method):
        # Each once: compositions have those of base and scheme.
        own = {(source.key, source.place): source for source in method.references}
        yield f"method {method.name}", tuple(own.values())


def _named(name: str) -> Scene | Method:
    try:
        return find_solver(name)
    except MethodError:
        return load_scene(name)
