"""Stress: every method on every system, along axes that end where methods stop working.

See `geomint.stress.judge` for the rules, `geomint.stress.case` for how packages give cases.
"""
