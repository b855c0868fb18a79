"""The tests of this folder share `blocks`, `session` and `catalogue`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
