"""Pictures of exact motions and of families of them, by matplotlib."""
