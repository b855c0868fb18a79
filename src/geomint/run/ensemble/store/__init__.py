"""Ensembles on disk, written block by block as they come."""
