"""Functions recorded in Python, and their compilation at need: kept on disk and never stale."""
