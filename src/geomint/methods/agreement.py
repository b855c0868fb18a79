"""Compiled code and plain Python give the same numbers: seen once, before the first step.

Both run the same kernels, to the same bits. The functions of a problem may be another matter: whole
numbers have 64 bits in compiled code, so that ``2**-k`` is 0 there and products wrap, and arrays of few
bits keep their kind. Nothing else would notice: checks in plain Python see the numbers that were meant.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..arguments import Array
from ..errors import DeclarationError
from ..kernels.numbers.blocks import scalar_block
from ..kernels.solve.status import OK

if TYPE_CHECKING:
    from .stepper import Stepper

SHORT = 0.25  # of a step: implicit ones have fewer iterations then
FEW = 40  # rows up to which a step in plain Python takes no time that one would notice
_agreeing: set[tuple[object, ...]] = set()


def check_agreement(stepper: Stepper) -> None:
    """Raise `DeclarationError` unless a first step, a short one, has the same bits compiled and not.

    Once for the functions of a problem in a process, by the method that meets them first. A step that
    fails is not judged: the run will report it, and the next one is looked at.
    """
    flow = stepper.flow.fixed
    key = tuple((f.recorded.fingerprint, f.rows) for f in flow.functions)
    if flow.compiled and flow.rows <= FEW and key not in _agreeing:
        ends = []
        for which in (flow, replace(flow, compiled=False)):
            alone = which.begin(stepper.state, stepper.t0, SHORT * stepper.h)
            alone.carry[:] = stepper.carry
            try:
                result = alone.advance(0, 1, 2, scalar_block(0))
            except (ArithmeticError, ValueError):
                return
            if result.status != OK:
                return
            ends.append(alone.state)
        _compare(flow.problem.name, *ends)
        _agreeing.add(key)
    stepper.flow.proven = True


def _compare(problem: str, compiled: Array, plain: Array) -> None:
    same = (compiled == plain) | np.isnan(compiled) & np.isnan(plain)
    if not same.all():
        row = int(np.argmin(same))
        what = (
            "give other numbers in compiled code than in Python: after a short step row "
            f"{row} is {compiled[row]!r} and {plain[row]!r}. Whole numbers have 64 bits there: "
            "2**-k is 0 and products wrap (2.0**-k is right), numpy numbers keep their kind "
            "(float32, uint8; float64 is right), and powers are rounded otherwise (y[0]**3; "
            "gi.pow(y[0], 3) is right)"
        )
        raise DeclarationError(problem, "functions", what)
