"""Spaces of states: points, conditions, random points, groups that move them; one file each."""
