"""Where methods and systems are published: what a reference is, and those of the methods of geomint."""
