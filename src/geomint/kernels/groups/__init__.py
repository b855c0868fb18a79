"""Lie groups and the maps of their algebras, in arithmetic that compiles."""
