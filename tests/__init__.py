"""The tests, the audit of the paper (`paper`), and problems of known structure (`problems`)."""
