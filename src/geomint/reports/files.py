"""The files of a report: page, JSON, CSV, pictures, and what is for a paper; all of them or none."""

from pathlib import Path

from ..run.files.outputs import UNSEALED, digest, whole_folder
from ..run.provenance import json_text
from .latex import write_paper
from .page import page
from .report import Report


def write(report: Report, folder: Path, paper: bool = False) -> Path:
    """Write the files of a report; return the path of the page. `paper`: those for a paper too.

    Raises
    ------
    OutputError
        If the folder cannot be written; what was there is as it was.
    """
    stem = report.stem
    with whole_folder(folder, report.files) as unfinished:
        (unfinished / report.page).write_text(page(report), encoding="utf-8")
        for picture, drawn in report.pictures.items():
            drawn.save(unfinished, picture)
        if report.csv is not None:
            report.csv(unfinished / f"{stem}.csv")
        if paper and report.printed is not None:
            write_paper(report, report.printed, unfinished)
        data = (report.json or json_text)(report.record)
        (unfinished / f"{stem}.json").write_bytes(sealed(data, f"{stem}.json", unfinished))
    return folder / report.page


def sealed(data: str, name: str, folder: Path) -> bytes:
    """Return a JSON with the digests of a report's files, its own too, by which the next knows them."""
    files = {file.name: digest(file.read_bytes()) for file in sorted(folder.iterdir())}
    told = json_text({"files": {**files, name: UNSEALED}})
    head, _, end = f"{data.rstrip().removesuffix('}').rstrip()},{told[1:]}".rpartition(UNSEALED)
    return f"{head}{digest(f'{head}{UNSEALED}{end}'.encode())}{end}".encode()
