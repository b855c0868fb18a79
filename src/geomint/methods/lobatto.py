"""RATTLE with more stages: the pairs of Lobatto IIIA and IIIB on the Hamiltonian form."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..arguments import Array, whole
from ..kernels.numbers.blocks import packed
from ..kernels.numbers.lanes import LANES
from ..kernels.solve.lobatto import (
    lobatto_coefficients,
    lobatto_memory,
    lobatto_stepper,
    lobatto_work,
)
from ..references.literature import HLW_2006, JAY_1996
from ..tableaux import MAX_LOBATTO_STAGES, lobatto_pair
from .binding import in_lanes
from .flow import Flow
from .gauss import predictor_columns, spread_columns, spread_vector
from .posed import Posed
from .rattle import Rattle, unrolled_sizes


@dataclass(frozen=True, repr=False)
class Lobatto(Rattle):
    """RATTLE with 3 to 8 stages, order 4 to 14: the pair of Lobatto IIIA and IIIB.

    For any Hamiltonian H(t, q, p) with holonomic constraints g(q) = 0; `Rattle` is the pair with two
    stages. Symplectic on the constraint manifold, symmetric, constraints met to rounding by every
    step, and nothing of order 2 inside: for any H that is not separable, and for small errors of
    others, to be preferred to compositions of `Rattle`.

    Parameters
    ----------
    stages : int
        s; the order is 2 s − 2.
    iteration_tolerance, max_iterations
        As for `geomint.Gauss`; the unknowns are measured relative to the size of q and of p.

    Notes
    -----
    All stages are iterated at once by fixed point; the multipliers of all by one Newton step inside
    each iteration (`geomint.kernels.solve.lobatto`).
    """

    stages: int = 8

    family = "Lobatto IIIA–IIIB"
    references = (JAY_1996, HLW_2006.at("Section VII.1.4"))

    def __post_init__(self) -> None:
        super().__post_init__()
        stages = whole("stages", self.stages, 3, MAX_LOBATTO_STAGES)
        self._set(
            stages=stages,
            name=f"lobatto-{stages}",
            order=2 * stages - 2,
            step_fraction=min(0.02 * 1.65 ** (stages - 2), 0.15),
            summary=f"RATTLE with {stages} stages, implicit",
        )

    def flow(self, p: Posed) -> Flow:
        functions, n, m = p.hamiltonian
        laned, scratch = zip(*(in_lanes(f, p) for f in functions), strict=True)
        clock = int(p.clock)
        return p.flow(
            kernel=lobatto_stepper(*unrolled_sizes(n, m)),
            functions=laned,
            coefficients=packed(
                lobatto_coefficients(len(p.lengths)),
                rows=n,
                constraints=m,
                cap=self.max_iterations,
                tolerance=self.iteration_tolerance,
                clock_rows=float(clock),
                **_lane_coefficients(self.stages, p.lengths),
            ),
            memory=lobatto_memory(n, m, clock),
            work=[LANES * rows for rows in lobatto_work(n, m, max(scratch))],
            evaluations=self.stages,
            stages_in_lanes=True,
        )


@functools.lru_cache(maxsize=64)
def _lane_coefficients(stages: int, lengths: tuple[float, ...]) -> Mapping[str, Array]:
    """Return c, b, which stages are later than the first and which is last, matrices in columns."""
    pair = lobatto_pair(stages)
    at = lane_positions(stages)
    number = np.arange(stages)
    return MappingProxyType(
        {
            "c": spread_vector(pair.c, at, LANES),
            "b": spread_vector(pair.b, at, LANES),
            "later": spread_vector(np.where(number > 0, 1.0, 0.0), at, LANES),
            "last": spread_vector(np.where(number == stages - 1, 1.0, 0.0), at, LANES),
            "mu": spread_columns(pair.mu, at, LANES),
            "nu": spread_columns(pair.nu, at, LANES),
            "impulses": spread_columns(pair.impulses, at, LANES),
            "predictors": predictor_columns(pair, lengths, at, LANES),
        }
    )


def lane_positions(stages: int) -> list[int]:
    """Return the lane of each stage: from both ends, so that the first is 0 and the last is 7."""
    left = (stages + 1) // 2
    return [i if i < left else LANES - stages + i for i in range(stages)]
