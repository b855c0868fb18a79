"""``python -m tests.paper``: what ``geomint audit`` is for an installation from these sources."""

import sys

from geomint.cli import main

from .command import audit

if __name__ == "__main__":
    main.add_command(audit)
    sys.argv[1:1] = ["audit"]  # pages say by which command they were written
    main(prog_name="geomint")
