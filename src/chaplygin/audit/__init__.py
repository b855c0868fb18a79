"""The audit: every checkable statement of the paper, evaluated at random admissible points.

A *claim* is one statement, written down as printed: a function that returns the two sides of an
equation at a point. Its verdict is computed from the residuals alone, see `claim`.

- ``claims_*`` hold the claims, a file a part of the paper, in the order of `run`;
- `motion` derives the truth, the motion of nonholonomic systems, from d'Alembert's principle;
- `forms` and `reduction` evaluate two-forms, divergences and brackets, `calculus` derivatives;
- `points` is the sampler, `run` evaluates, `report` writes, `command` is ``geomint audit``.

A claim about something new is a function in the file of its section. Nothing here uses the package's
own fields, except `claims_package`, which audits them in turn.
"""
