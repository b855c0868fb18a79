"""Numbers of several kinds in blocks of rows: float64, lanes of eight, double-double."""
