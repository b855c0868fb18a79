"""Comparisons of methods, and the references that their errors are measured against."""
