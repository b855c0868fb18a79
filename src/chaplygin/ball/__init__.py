"""The Chaplygin sphere in all its representations: see `sphere` for the ball itself."""
