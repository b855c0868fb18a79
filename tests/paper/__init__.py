"""The audit: every checkable statement of the paper, evaluated at random admissible points.

A *claim* is one statement, written down as printed: a function that returns the two sides of an
equation at a point. Its verdict is computed from the residuals alone, see `claim`.

- ``s…`` hold the claims: a file a section of the paper, named by its number, in the paper's order;
- `motion` derives the actual motion of nonholonomic systems, from d'Alembert's principle, and
  `momenta` what momenta do along it;
- `equations`, `classical` (n = 3), `stiefel` and `integrals` have what several sections use;
- `two_forms` and `reduction` evaluate two-forms, divergences and brackets, `calculus` derivatives;
- `points` is the sampler, `run` evaluates, `report` and `page` write, `command` is ``geomint audit``.

A claim about something new is a function in the file of its section; sections share nothing with each
other but these modules. The audit is an independent witness: it imports nothing of `chaplygin`, and
nothing of `chaplygin` imports it. The package's own equations are compared with its motions in the
tests.
"""
