"""The loop that every stepper shares: steps, substeps of a composition, saved states.

A method's step function has the signature ::

    step(functions, params, coefficients, substep, memory, work, t, h) -> (status, iterations, residual)

with `functions` a tuple of the problem's compiled functions. It reads and writes ``memory``, whose
first rows are the state, the next rows the carries of the compensated sums, and the rest whatever
the next step depends on: saved whole, memory makes a resumed run bit-identical.
"""

from ..compiling.bound import Bound
from ..compiling.recorded import Recorded, helper
from ..compiling.signatures import advance as signature_of
from ..numbers.arithmetic import top
from .ranks import counts, keep, rank_by_differences, rank_by_own_number
from .status import OK, Steps


def stepper(step: Recorded, ranked: bool = False) -> Recorded:
    """Return the loop of a method's step: what is compiled, and runs.

    `ranked`: whether the residual of a step ranks it (`geomint.kernels.solve.ranks`).
    """
    rank = rank_by_own_number if ranked else rank_by_differences

    # A dispatcher that is handed on as an argument is an address in the machine code, which no
    # other process can use; one that is a closure value is code.
    def advance(
        functions, params, coefficients, fractions, memory, work, rows: int, t0: float, h: float,
        first: int, count: int, every: int, out, ranks,
    ) -> Steps:  # fmt: skip
        """Take `count` steps and write every `every`-th state into `out`.

        Parameters
        ----------
        fractions : block, shape (2 m,)
            For each of the m substeps of a composition its length and its start, in units of `h`.
        first : int
            Number of steps taken before: the time is ``t0 + i h``, never accumulated.
        ranks : block
            What ranks the steps (`geomint.kernels.solve.ranks`); empty for nothing.

        Returns
        -------
        status, steps, iterations, residual
            `steps` completed steps; on failure `residual` is what the last step left, and memory
            may hold the first substeps of it.
        """
        saved = 0
        watched, new, own = len(ranks) > 0, 0, 0.0
        window, ranked, often, slot = counts(ranks) if watched else (0, 0, 0, 0)
        iterations = 0
        substeps = len(fractions) // 2
        for k in range(count):
            t = t0 + (first + k) * h
            for j in range(substeps):
                status, used, residual = step(
                    functions, params, coefficients, j, memory, work,
                    t + fractions[substeps + j] * h, fractions[j] * h,
                )  # fmt: skip
                iterations += used
                if status != OK:
                    return status, k, iterations, residual
            if (first + k + 1) % every == 0:
                for r in range(rows):
                    out[saved * rows + r] = memory[r]
                saved += 1
            if watched:
                if new == often:
                    rank(ranks, first + k, new, own)
                    new = 0
                slot, own = keep(ranks, window, ranked, slot, memory), top(residual)
                new += 1
        if new > 0:
            rank(ranks, first + count, new, own)
        return OK, count, iterations, 0.0

    advance.__name__ = step.function.__name__  # what "compiling …" says
    return helper(advance)


def with_maps(step: Recorded, *maps: Recorded | None) -> Recorded:
    """Return a step, or an attempt, that finds the maps of a group.

    It takes them after its generator: ``step((generator, *maps), …)``. Where they are given here
    they are compiled in, and ``step`` takes (generator,).
    """

    def compiled_in(functions, *others):
        return step(functions[0], maps, *others)

    def taken(functions, *others):
        return step(functions[0], functions[1:], *others)

    chosen = taken if maps[0] is None else compiled_in
    chosen.__name__ = f"{step.function.__name__}{'' if chosen is taken else '_in'}"
    return helper(chosen)


def bound_stepper(kernel: Recorded, functions: tuple[Bound, ...]) -> Bound:
    """Return the entry of a method with its signature, which those of its functions decide."""
    return Bound(kernel, signature_of(f.signature for f in functions))
