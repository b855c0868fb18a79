"""One step of every family of methods, and the loops over steps."""
