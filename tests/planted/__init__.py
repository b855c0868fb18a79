"""Planted faults and drawn mutants: what of the code the tests do not see."""
