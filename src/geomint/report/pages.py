"""HTML pages from templates: self-contained, everything escaped.

Other packages make their pages with it too: a template of theirs extends ``page.html.j2``, whose blocks
are ``kind``, ``json``, ``style`` and ``main``. It wants a `title`, the `provenance` of `provenance_of`,
and shows a `citation` where one is given.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ..errors import printable
from ..plots.style import Picture, data_uri
from ..run.files.outputs import UNSEALED, digest, whole_folder
from ..run.provenance import environment, finite_json, json_text
from ..scene.provenance import scene_record
from . import paper_files, report_files
from .cite import cite
from .paper import Paper, Printed, scene_facts
from .text import Record, number, with_error

if TYPE_CHECKING:
    from ..plan import ChaosPlan, ScanPlan, SectionPlan
    from ..scene import Scene

__all__ = [
    "Picture",
    "data_uri",
    "json_of",
    "paper_files",
    "provenance_of",
    "render",
    "report_files",
    "section",
    "write_files",
    "write_planned",
]

OWN = "geomint.report"


def _harmless(value: Any) -> Any:
    """Return a value without control characters, which no HTML may have and which may mislead."""
    plain = isinstance(value, str) and not isinstance(value, Markup)
    return printable(value) if plain and not value.isprintable() else value


@functools.cache
def _environment(package: str) -> Environment:
    made = Environment(
        loader=ChoiceLoader([PackageLoader(package), PackageLoader(OWN)]),
        autoescape=True,
        finalize=_harmless,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.globals.update(number=number, with_error=with_error)
    return made


def render(template: str, package: str = OWN, **context: Any) -> str:
    """Return a page; templates share ``report.css`` and have `number` and `with_error`.

    Parameters
    ----------
    template : str
        In the folder ``templates`` of the package, or of this one.
    package : str
    **context
        What it shows; without something that it asks for it is no page but an error.
    """
    return _environment(package).get_template(template).render(**context)


def provenance_of(scene: Scene | None, command: str | None) -> Record:
    """Return where a result comes from: versions, processor, date, and what was asked for."""
    return {**environment(), "command": command} if scene is None else scene_record(scene, command)


def json_of(record: Mapping[str, Any]) -> str:
    """Return a record as the text of a file of strict JSON: what is not finite is null."""
    return json_text(finite_json(record))


def section(template: str, content: Mapping[str, Any] | None) -> Markup:
    """Return a part of a page from its own template; nothing if it has no content."""
    return Markup("" if content is None else render(template, **content))


def write_files(
    folder: Path,
    names: Sequence[str],
    page: str,
    data: str,
    pictures: Mapping[str, Picture],
    others: Mapping[str, Callable[[Path], None]] = MappingProxyType({}),
    paper: Paper | None = None,
) -> Path:
    """Write the files of a report, all or none: page, JSON, and each picture as PNG and SVG.

    And the `others`, by functions that take a path; with a `paper` all that is for one. Returns the
    path of the page.

    Raises
    ------
    OutputError
        If the folder cannot be written; what was there is as it was.
    """
    html, json = (next(n for n in names if n.endswith(kind)) for kind in (".html", ".json"))
    with whole_folder(folder, names) as unfinished:
        (unfinished / html).write_text(page, encoding="utf-8")
        for name, picture in pictures.items():
            picture.save(unfinished, name)
        for name, write in others.items():
            write(unfinished / name)
        if paper is not None:
            paper.write(unfinished, {name: p.figure for name, p in pictures.items()})
        (unfinished / json).write_bytes(sealed(data, json, unfinished))
    return folder / html


def sealed(data: str, name: str, folder: Path) -> bytes:
    """Return a JSON with the digests of a report's files, its own too, by which the next knows them."""
    files = {file.name: digest(file.read_bytes()) for file in sorted(folder.iterdir())}
    told = json_text({"files": {**files, name: UNSEALED}})
    head, _, end = f"{data.rstrip().removesuffix('}').rstrip()},{told[1:]}".rpartition(UNSEALED)
    return f"{head}{digest(f'{head}{UNSEALED}{end}'.encode())}{end}".encode()


def write_planned(
    stem: str,
    plan: ChaosPlan | ScanPlan | SectionPlan,
    record: Record,
    picture: Picture,
    save: Callable[[Path], None],
    folder: Path,
    paper: Printed | None,
    **shown: Any,
) -> Path:
    """Write the report of a plan that was carried out, all files or none; return the path of the page.

    Parameters
    ----------
    stem : str
        What its template, and all files, begin with.
    plan : ChaosPlan, ScanPlan or SectionPlan
    record : mapping
        The content of the JSON, with its `provenance`.
    picture : Picture
    save : callable
        Writes the CSV to a path.
    folder : Path
    paper : (caption, table, method), optional
        For what goes into a paper; the method in words.
    **shown
        What else the template shows.

    Raises
    ------
    OutputError
    """
    citation, provenance = cite(plan.route.problem, plan.scene.method), record["provenance"]
    page = render(
        f"{stem}.html.j2",
        title=plan.scene.title,
        record=record,
        provenance=provenance,
        citation=citation,
        picture=picture.uri,
        **shown,
    )
    more = None
    if paper is not None:
        caption, table, method = paper
        name = provenance["scene"]["system"]["name"]
        system = f"{name}, in the representation {plan.route.name}"
        facts = scene_facts(provenance, system, method)
        more = Paper(stem, caption, table, facts, citation, command=provenance["command"])
    others = {f"{stem}.csv": save}
    files = report_files(stem)
    return write_files(folder, files, page, json_text(record), {stem: picture}, others, more)
