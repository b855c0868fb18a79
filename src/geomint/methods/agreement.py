"""Compiled code and plain Python give the same numbers: seen once, before the first step.

Both run the same kernels, to the same bits. The functions of a problem may be another matter: whole
numbers have 64 bits in compiled code, so that ``2**-k`` is 0 there and products wrap, and arrays of few
bits keep their kind. Nothing else would notice: checks in plain Python see the numbers that were meant.
"""

from dataclasses import replace

import numpy as np

from ..errors import DeclarationError
from ..kernels.numbers.blocks import scalar_block
from ..kernels.solve.status import OK
from .stepper import Stepper

SHORT = 0.25  # of a step: implicit ones have fewer iterations then
FEW = 40  # rows up to which a step in plain Python takes no time that one would notice
_agreeing: set[tuple[object, ...]] = set()


def check_agreement(problem: str, stepper: Stepper) -> None:
    """Raise `DeclarationError` unless a first step, a short one, has the same bits compiled and not.

    Once for the functions of a problem in a process, by the method that meets them first. A step that
    fails is not judged: the run will report it.
    """
    key = tuple((f.recorded.fingerprint, f.rows) for f in stepper.functions)
    if not stepper.compiled or stepper.rows > FEW or key in _agreeing:
        return
    ends = []
    for compiled in (True, False):
        fixed = stepper.restarted(
            stepper.state.copy(), stepper.t0, SHORT * stepper.h, stepper.carry
        )
        if not compiled:
            fixed = replace(fixed, compiled=False)
        try:
            result = fixed.advance(0, 1, 2, scalar_block(0))
        except (ArithmeticError, ValueError):
            return
        if result.status != OK:
            return
        ends.append(fixed.state)
    same = (ends[0] == ends[1]) | np.isnan(ends[0]) & np.isnan(ends[1])
    if not same.all():
        row = int(np.argmin(same))
        what = (
            "give other numbers in compiled code than in Python: after a short step row "
            f"{row} is {ends[0][row]!r} and {ends[1][row]!r}. Whole numbers have 64 bits there: "
            "2**-k is 0 and products wrap (2.0**-k is right), numpy numbers keep their kind "
            "(float32, uint8; float64 is right), and powers are rounded otherwise (y[0]**3; "
            "gi.pow(y[0], 3) is right)"
        )
        raise DeclarationError(problem, "functions", what)
    _agreeing.add(key)
