"""What was found, said once: a value that pages, terminals, papers and programs show.

A report is made of parts, these of blocks, and tables of typed cells. What shows them: `page` (HTML),
`terminal`, `latex` (for a paper) and `files` (all of these, JSON and CSV in a folder).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from ..plots.style import Picture as Picture
from ..run.variables import optional
from .cite import Citation
from .text import Record, number, with_error

# --- cells -----------------------------------------------------------------------------------------


class Num(NamedTuple):
    """A number: to so many digits, or with its standard error; of a bound what it is at most."""

    value: float | None
    digits: int = 3
    error: float | None = None
    bound: bool = False

    def __str__(self) -> str:
        if self.error is not None:
            return with_error(self.value, self.error)
        return f"{'≤ ' if self.bound else ''}{number(self.value, self.digits)}"


# Classes of drift as readers have them; records have short ones.
SHOWN = {"sqrt": "random walk", "roundoff": "round-off", "faster": "faster than linear"}


class Verdict(NamedTuple):
    """A word for what became of something, such as a class of drift; pages give it a colour."""

    word: str

    def __str__(self) -> str:
        return SHOWN.get(self.word, self.word)


class Small(NamedTuple):
    """What is said beside, in smaller letters."""

    text: str

    def __str__(self) -> str:
        return self.text


class Marked(NamedTuple):
    """Text beside its mark in pictures: a colour, or the line of a legend as a data URI."""

    text: str
    mark: str

    def __str__(self) -> str:
        return self.text


class Stack(tuple["Cell", ...]):
    """Cells one below the other, the first the most important."""

    def __str__(self) -> str:
        return " ".join(str(cell) for cell in self if str(cell))


Cell = str | Num | Verdict | Small | Marked | Stack


# --- blocks ----------------------------------------------------------------------------------------


class Prose(NamedTuple):
    """A paragraph; what is between backticks is code."""

    text: str
    small: bool = True


class Code(NamedTuple):
    """Lines as they are: equations, rules."""

    text: str
    kind: str = "rule"


class Listing(NamedTuple):
    """A list of sentences."""

    items: Sequence[str]


class Facts(NamedTuple):
    """Short values by their names."""

    values: Mapping[str, str]


class Words(NamedTuple):
    """Sentences by what they are about."""

    values: Iterable[tuple[Cell, str]]
    kind: str = "classes"


class Images(NamedTuple):
    """Pictures that are seen together, as data URIs with what they show; `kind` places them."""

    images: Sequence[tuple[str, str]]
    kind: str = "panels"


class Legend(NamedTuple):
    """The lines of pictures."""

    lines: Sequence[Marked]


@dataclass(frozen=True)
class Table:
    """A table; columns name their units. A row that is too short ends in a remark.

    Attributes
    ----------
    columns : sequence of str or Cell
        None has a heading in a table of two or three columns that are decisions or parameters.
    rows : sequence of sequence of Cell
    words : int
        How many columns, the first ones, hold words: the others are aligned at the right.
    kind : str
        ``"quantities"``, ``"quantities matrix"``, ``"quantities counts"``, whose headings and
        cells may have several lines on a terminal, or ``"plan"``, which needs no headings.
    told : bool
        Whether a terminal shows it.
    spare : sequence of str
        Headings of columns that a narrow terminal leaves out, one after the other.
    """

    columns: Sequence[Cell]
    rows: Sequence[Sequence[Cell]]
    words: int = 1
    kind: str = "quantities"
    told: bool = True
    spare: Sequence[str] = ()


class Folded(NamedTuple):
    """What is seen when its summary is chosen."""

    summary: str
    blocks: tuple[Block, ...]


class Part(NamedTuple):
    """Blocks below a heading; a part may have parts."""

    heading: str
    blocks: tuple[Block, ...]


Block = Prose | Code | Listing | Facts | Words | Images | Legend | Table | Folded | Part


# --- the whole -------------------------------------------------------------------------------------


class Printed(NamedTuple):
    """What of a report goes into a paper.

    Attributes
    ----------
    caption : str
        What the figure shows, a sentence or more.
    table : Table
    facts : mapping of str to str
        What was computed and how: system, method, versions. Those under ``"System"``, ``"Method"`` and
        ``"Software"`` are followed by what is to be cited for them.
    data : sequence of rows, optional
        For ``STEM.csv``, the names of columns first; None where the report has such a file.
    """

    caption: str
    table: Table
    facts: Mapping[str, str]
    data: Sequence[Sequence[Any]] | None = None


@dataclass(frozen=True, eq=False)
class Report:
    """What a command found.

    Attributes
    ----------
    files : tuple of str
        The names of all that may lie in its folder.
    kind, title : str
        In words: of reports of this kind, and of this one.
    verdict : str, or sequence of (str, str)
        What was found, in a sentence or two; or by what it is about.
    blocks : sequence of Block
    record : mapping
        The content of the JSON, with its `provenance`.
    status, outcome : str
        ``"success"``, or what became of it; and what decides the exit code, if that is another one.
    failures : sequence of str
        What a shell says on standard error: that parts of it have no result, and why.
    summary : str
        What was run, in a line, for terminals.
    lead : sequence of str
        What it is about.
    alerts : sequence of (str, str)
        What a reader must not miss: in a word, and in sentences.
    pictures : mapping of str to Picture
        Those that are files too, by their names.
    citation : Citation, optional
    csv : callable, optional
        Writes ``STEM.csv`` to a path.
    printed : Printed, optional
    json : callable, optional
        Returns the text of the JSON, where it is not that of all others.
    """

    files: tuple[str, ...]
    kind: str
    title: str
    verdict: str | Sequence[tuple[str, str]]
    blocks: Sequence[Block]
    record: Record
    status: str = "success"
    summary: str = ""
    lead: Sequence[str] = ()
    alerts: Sequence[tuple[str, str]] = ()
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    citation: Citation | None = None
    csv: Callable[[Path], None] | None = None
    printed: Printed | None = None
    outcome: str = ""
    failures: Sequence[str] = ()
    json: Callable[[Record], str] | None = None

    @property
    def page(self) -> str:
        """The name of its page."""
        return next(name for name in self.files if name.endswith(".html"))

    @property
    def stem(self) -> str:
        """What the names of its files begin with."""
        return next(name for name in self.files if name.endswith(".json")).removesuffix(".json")

    @property
    def provenance(self) -> Record:
        """Versions, processor, date, and what was asked for."""
        found: Record = self.record["provenance"]
        return found

    def write(self, folder: Path, paper: bool = False) -> Path:
        """Write its files, all or none, as `files` does, and return the path of the page."""
        from .files import write

        return write(self, folder, paper)

    def to_dataframe(self) -> Any:
        """Return the numbers of its CSV as a `pandas.DataFrame`."""
        pandas = optional("pandas", "to_dataframe")
        if self.csv is None and self.printed and self.printed.data:
            names, *rows = self.printed.data
            return pandas.DataFrame(rows, columns=list(names))
        if self.csv is None:  # the first table of the JSON
            found = (x for x in self.record.values() if isinstance(x, list))
            return pandas.DataFrame(next(found, []))
        with TemporaryDirectory() as folder:
            self.csv(path := Path(folder) / "data.csv")
            return pandas.read_csv(path)

    def tables(self) -> Iterator[tuple[str, Table]]:
        """Yield the tables of the report; of what is folded with its summary."""
        yield from _tables(self.blocks)

    def _repr_html_(self) -> str:
        from .page import framed

        return framed(self)


def _tables(blocks: Iterable[Block], summary: str = "") -> Iterator[tuple[str, Table]]:
    for block in blocks:
        if isinstance(block, Table):
            yield summary, block
        elif isinstance(block, Folded | Part):
            yield from _tables(block.blocks, getattr(block, "summary", summary))


def of_warnings(warnings: Iterable[Mapping[str, Any]], label: str = "") -> list[tuple[str, str]]:
    """Return warnings, as they are in records, as alerts."""
    return [(f"{label}{warning['kind']}.", f"{warning['text']}.") for warning in warnings]
