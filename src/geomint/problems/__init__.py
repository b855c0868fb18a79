"""Problems: what is integrated, in which forms, and what is checked before anything runs."""
