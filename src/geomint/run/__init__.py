"""Runs: from an initial state to a solution, and to its file."""
