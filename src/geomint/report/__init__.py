"""Reports: plots, HTML pages that open from disk, and JSON beside them. Nothing is integrated here."""


def paper_files(stem: str, *figures: str, csv: bool = True) -> tuple[str, ...]:
    """Return what `geomint.report.paper` adds: of an earlier report nothing stays."""
    files = (f"{stem}-table.tex", f"{stem}-caption.tex", f"{stem}-paper.tex", f"{stem}.bib")
    pictures = (f"{name}.pdf" for name in (stem, *figures))
    return (*files, *pictures, *((f"{stem}.csv",) if csv else ()))


def report_files(stem: str) -> tuple[str, ...]:
    """Return the files of a report with one picture: always, and with what is for a paper."""
    own = (f"{stem}.{ending}" for ending in ("csv", "html", "json", "png", "svg"))
    return (*own, *paper_files(stem, csv=False))


# What lies in the folder of a report: always, and with what is for a paper.
DRIFT_FILES = ("drift.json", "drift.png", "drift.svg", "report.html", *paper_files("drift"))
COMPARE_FILES = (
    "compare.html",
    "compare.json",
    "compare.png",
    "compare.svg",
    "compare-drift.png",
    "compare-drift.svg",
    *paper_files("compare", "compare-drift"),
)
STRESS_FILES = ("stress.html", "stress.json", "stress.png", "stress.svg")
CHAOS_FILES = report_files("chaos")
SECTION_FILES = report_files("section")
SCAN_FILES = report_files("scan")
