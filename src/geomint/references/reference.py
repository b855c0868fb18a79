"""A published source: its text for readers, and its BibTeX entry."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from typing import Any

from ..errors import DomainError
from .latex import latex

__all__ = ["Reference", "checked_references"]

KINDS = ("article", "book", "incollection", "misc")
IN_BIBTEX = ("journal", "booktitle", "publisher", "series", "edition", "volume", "number", "pages",
             "note")  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Reference:
    """Where something is published.

    Parameters
    ----------
    key : str
        The key of its BibTeX entry: ASCII letters and digits, such as ``"Yoshida1990"``.
    authors : tuple of str
        Each as ``"Family, Given"``; an organisation without a comma.
    title : str
    year : int, optional
    kind : ``"article"``, ``"book"``, ``"incollection"`` or ``"misc"``
    journal, volume, number, pages, booktitle, publisher, series, edition, note : str, optional
        As BibTeX has them; pages as ``"262--268"``.
    doi, arxiv : str, optional
        Without an address.
    place : str, optional
        Where in the source, such as ``"Section V.3.2"``; no part of the entry. See `at`.

    Raises
    ------
    DomainError
        For another kind, a key with other characters, or fields that are no texts.

    Examples
    --------
    >>> import geomint as gi
    >>> own = gi.Reference(key="Own2026", authors=("Doe, Jane",), title="A method", year=2026)
    >>> own.text
    'J. Doe, A method, 2026.'
    """

    key: str
    authors: tuple[str, ...]
    title: str
    year: int | None = None
    kind: str = "article"
    journal: str = ""
    volume: str = ""
    number: str = ""
    pages: str = ""
    booktitle: str = ""
    publisher: str = ""
    series: str = ""
    edition: str = ""
    note: str = ""
    doi: str = ""
    arxiv: str = ""
    place: str = ""

    def __post_init__(self) -> None:
        if not (isinstance(self.key, str) and re.fullmatch(r"[A-Za-z][A-Za-z0-9]*", self.key)):
            raise DomainError("key", self.key, "ASCII letters and digits, a letter first")
        authors = (self.authors,) if isinstance(self.authors, str) else self.authors
        if not isinstance(authors, list | tuple) or not all(isinstance(a, str) for a in authors):
            raise DomainError("authors", self.authors, "a tuple of texts, 'Family, Given'")
        object.__setattr__(self, "authors", tuple(authors))
        if self.kind not in KINDS:
            raise DomainError("kind", self.kind, f"one of {', '.join(KINDS)}")
        if not (self.year is None or type(self.year) is int):
            raise DomainError("year", self.year, "a whole number, or None")
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.name not in ("authors", "year") and not isinstance(value, str):
                raise DomainError(field.name, value, "a text")

    def at(self, place: str) -> Reference:
        """Return the reference with the place in it."""
        return dataclasses.replace(self, place=place)

    @property
    def text(self) -> str:
        """Return it as a list of references has it."""
        authors = ", ".join(_initials(author) for author in self.authors)
        where = []
        if self.journal:
            year = f"({self.year})" if self.year else ""
            where.append(" ".join(filter(None, (self.journal, self.volume, year, self.pages))))
        else:
            inside = f"in: {self.booktitle}" if self.booktitle else ""
            edition = f"{self.edition} ed." if self.edition else ""
            pages = f"pp. {self.pages}" if self.pages else ""
            year = str(self.year) if self.year else ""
            parts = (inside, edition, self.series, self.publisher, year, pages)
            where += filter(None, parts)
        where.append(self.note)
        where.append(f"doi:{self.doi}" if self.doi else "")
        where.append(f"arXiv:{self.arxiv}" if self.arxiv else "")
        where.append(self.place)
        words = ", ".join(filter(None, (authors, self.title, *where)))
        return words.replace("--", "–") + "."

    @property
    def bibtex(self) -> str:
        """Return its BibTeX entry, in ASCII."""
        fields = {
            "author": " and ".join(
                latex(a) if "," in a else f"{{{latex(a)}}}" for a in self.authors
            ),
            "title": f"{{{latex(self.title)}}}",
            "year": str(self.year or ""),
        }
        fields |= {name: latex(getattr(self, name)) for name in IN_BIBTEX}
        fields["doi"] = self.doi
        fields |= {"eprint": self.arxiv, "archiveprefix": "arXiv" if self.arxiv else ""}
        lines = [f"  {name} = {{{value}}}" for name, value in fields.items() if value]
        return f"@{self.kind}{{{self.key},\n" + ",\n".join(lines) + "\n}\n"


def _initials(author: str) -> str:
    """Return ``"Munthe-Kaas, Hans"`` as ``"H. Munthe-Kaas"``."""
    family, comma, given = author.partition(", ")
    if not comma:
        return author
    initials = re.sub(r"(\w)[\w’']*\.?", r"\1.", given)
    return f"{initials} {family}"


def checked_references(references: Any) -> tuple[Reference, ...]:
    """Return references as a tuple, or raise `DomainError`."""
    if isinstance(references, Reference):
        return (references,)
    given = references if isinstance(references, list | tuple) else [references]
    if not all(isinstance(one, Reference) for one in given):
        raise DomainError("references", references, "a tuple of geomint.Reference")
    return tuple(given)
