"""Runs without steps: the exact motion of a problem, its states and events at any time."""
