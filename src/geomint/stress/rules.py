"""The rules by which cells are judged, in words: what `geomint.stress.judge` does."""

from pathlib import Path

RULES = Path(__file__).with_name("rules.txt").read_text(encoding="utf-8")
