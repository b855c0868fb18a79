"""The rubber ball, which rolls without slipping and without twisting: see `sphere`."""
