"""Reports: plots, HTML pages that open from disk, and JSON beside them. Nothing is integrated here."""

# What lies in the folder of a report.
DRIFT_FILES = ("drift.json", "drift.png", "drift.svg", "report.html")
COMPARE_FILES = (
    "compare.html",
    "compare.json",
    "compare.png",
    "compare.svg",
    "compare-drift.png",
    "compare-drift.svg",
)
STRESS_FILES = ("stress.html", "stress.json", "stress.png", "stress.svg")
CHAOS_FILES = ("chaos.csv", "chaos.html", "chaos.json", "chaos.png", "chaos.svg")
SECTION_FILES = ("section.csv", "section.html", "section.json", "section.png", "section.svg")
SCAN_FILES = ("scan.csv", "scan.html", "scan.json", "scan.png", "scan.svg")
