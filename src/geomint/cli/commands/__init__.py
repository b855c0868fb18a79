"""The table of commands: one module for each, and nothing that lists them.

See `geomint.cli.command`. ``geomint --help`` reads the first lines of the modules.
"""
