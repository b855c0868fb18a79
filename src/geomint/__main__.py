"""``python -m geomint`` is the command ``geomint``."""

from .cli import main

if __name__ == "__main__":
    main(prog_name="geomint")
