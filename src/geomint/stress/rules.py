"""The rules by which cells are judged, in words: what `geomint.stress.judge` does."""

from pathlib import Path

__all__ = ["RULES"]

RULES = Path(__file__).with_name("rules.txt").read_text(encoding="utf-8")
