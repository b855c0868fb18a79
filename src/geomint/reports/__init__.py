"""Reports: plots, HTML pages that open from disk, and JSON beside them. Nothing is integrated here."""


def files_of(
    stem: str,
    *pictures: str,
    page: str = "",
    csv: bool = True,
    paper: bool = True,
    picture: bool = True,
) -> tuple[str, ...]:
    """Return what lies in the folder of a report: of an earlier one nothing stays.

    Parameters
    ----------
    stem : str
        What names of files begin with.
    *pictures : str
        Names of those beside the one that is called as the report.
    page : str
        The name of the page, if it is not STEM.html.
    csv, paper, picture : bool
        Whether there is a table of data that is for no paper, anything for a paper, a picture of that
        name.
    """
    names = [*[stem] * picture, *pictures]
    found = [page or f"{stem}.html", f"{stem}.json", *[f"{stem}.csv"] * csv]
    found += [f"{name}.{ending}" for name in names for ending in ("png", "svg")]
    if paper:
        found += [f"{stem}-table.tex", f"{stem}-caption.tex", f"{stem}-paper.tex", f"{stem}.bib"]
        found += [*[f"{stem}.csv"] * (not csv), *(f"{name}.pdf" for name in names)]
    return tuple(found)


DRIFT_FILES = files_of("drift", page="report.html", csv=False)
COMPARE_FILES = files_of("compare", "compare-drift", csv=False)
STRESS_FILES = files_of("stress", csv=False, paper=False)
CHAOS_FILES, SECTION_FILES, SCAN_FILES = map(files_of, ("chaos", "section", "scan"))
