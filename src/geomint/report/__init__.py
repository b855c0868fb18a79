"""Reports: plots, HTML pages that open from disk, and JSON beside them. Nothing is integrated here."""


def paper_files(stem: str, *figures: str, csv: bool = True) -> tuple[str, ...]:
    """Return what `geomint.report.paper` adds: of an earlier report nothing stays."""
    files = (f"{stem}-table.tex", f"{stem}-caption.tex", f"{stem}-paper.tex", f"{stem}.bib")
    pictures = (f"{name}.pdf" for name in (stem, *figures))
    return (*files, *pictures, *((f"{stem}.csv",) if csv else ()))


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
CHAOS_FILES = (
    "chaos.csv",
    "chaos.html",
    "chaos.json",
    "chaos.png",
    "chaos.svg",
    *paper_files("chaos", csv=False),
)
SECTION_FILES = (
    "section.csv",
    "section.html",
    "section.json",
    "section.png",
    "section.svg",
    *paper_files("section", csv=False),
)
SCAN_FILES = (
    "scan.csv",
    "scan.html",
    "scan.json",
    "scan.png",
    "scan.svg",
    *paper_files("scan", csv=False),
)
