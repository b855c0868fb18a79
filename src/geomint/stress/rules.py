"""The rules by which cells are judged, in words: what `geomint.stress.judge` does."""

__all__ = ["RULES"]

RULES = """\
Verdicts, the first that applies. ε = 2⁻⁵²; T is the length of the run in characteristic times, at
least 1; N that in shortest times of the motion, at most the number of steps, at least T; p the
order, counted up to 8; φ what rounding makes of the field, relative, in the time of the run.

==========  ========================================================================================
refused     a typed error before the first step: parameters, state or step outside of the domain
failed      a typed error of a step, that says where, with a finite partial solution
untyped     any other error or warning, or a process that died
hung        longer than the time allowed
wrong       success, but a number is not finite, or a quantity that the method preserves is
            off by more than 32 ε N · scale + φ · scale of pieces (group orbits, which any generator
            keeps: without φ), or the accuracy is not that stated: see the last line
ok          the state is off by round-off, (32 ε T + φ) · condition at most; or by less than 0.1, and
            one of three halvings of the step divides that by 2^(p/2) or more, or brings it to
            round-off.
            Of adaptive methods: by the tolerance of a step · condition · their number, at most
unresolved  not ok, and none can be expected: the step is longer than the method's default for the
            shortest time of the motion, or round-off alone may grow to 0.1, or there is no
            reference and an adaptive method wants more than 200 000 steps at finer tolerance
==========  ========================================================================================

What is neither ok nor unresolved is wrong. The error of the state is the largest difference of a
piece from the reference, relative to that piece, or to the state where the piece is 0. A reference
is a double-double solution that is known to 3 ε by its own estimate, and that DOP853, twice at
different tolerances, confirms to the accuracy which that reaches. One that is not is refused, and
the cell says why. Where there is none the error is the difference from the same method at half the
step, or with a sixteenth of the tolerance. The shortest time of the motion is the shortest
characteristic time of the states of the run, or ten times that in which neighbouring states part by
a factor e, whichever is shorter. Scales of what an iteration keeps count numbers with the size of
their piece. How `condition` is measured: `geomint.stress.known_end`. A steady motion is never
unresolved by a method that follows it. Adaptive methods may take 200 000 steps. φ is seen where
the field in double precision differs from that in extended precision, at states next to the first.
"""
