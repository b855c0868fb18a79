"""The tests of this folder share `blocks`, `session` and `catalogue`, and `tables` of the pages."""

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[2] / "docs")]
