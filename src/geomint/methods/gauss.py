"""Gauss collocation methods: symmetric, symplectic in flat space, of order twice the stages."""

import functools
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from types import MappingProxyType

import numpy as np

from ..arguments import Array, switch, whole
from ..errors import DomainError
from ..kernels.numbers.blocks import filled_block, packed
from ..kernels.numbers.lanes import LANES
from ..kernels.solve.gauss import gauss_coefficients, gauss_memory, gauss_stepper, gauss_work
from ..kernels.solve.gauss_between import gauss_between, gauss_inside, gauss_polynomial
from ..references.literature import BUTCHER_1964, HLW_2006
from ..tableaux import GaussTableau, LobattoPair, gauss_legendre
from .binding import in_lanes
from .flow import Between, Flow, Kernel
from .gauss_newton import check_derivatives, newton_kernel
from .method import Method, iteration_tolerance
from .posed import Posed, unrolled

MAX_UNROLLED_ROWS = 16  # a fixed-point iteration gains more than an explicit step
ITERATIONS = ("auto", "fixed-point", "newton")
PATIENCE = 3  # a part of the iterations after which a step is looked at
MAX_EXTRAPOLATION = 1.5  # substeps longer than this, against the last one, start from nothing


@dataclass(frozen=True, repr=False)
class Gauss(Method):
    """Gauss collocation with 1 to 16 stages.

    Parameters
    ----------
    stages : int
        s; the order is 2 s. ``Gauss(1)`` is the implicit midpoint rule.
    iteration_tolerance : float
        0, the default: the fixed-point iteration goes on until rounding lets it fall no further,
        so that no bias is left and invariants do a random walk. Else it stops when what a further
        iteration would change, estimated from the last two, is less than the tolerance relative to
        the state's pieces: 2⁻⁵⁶ saves an eighth of the time and lets invariants drift linearly by
        some 1e-17 a step.
    max_iterations : int
        After which a `ConvergenceError` is raised, or Newton's method takes over; its cap too, and
        thrice that of its tries together.
    iteration : ``"auto"``, ``"fixed-point"`` or ``"newton"``
        How stages are solved for. ``"auto"``, the default: each step by fixed-point iteration if it
        contracts, and else by Newton's method. What is found is the same, to rounding.
    fused : bool
        Compile the field into the stepper of the fixed-point iteration: the same bits, in 0.85 of the
        time where fields are small, for some seconds of compilation for each problem in each process.

    Notes
    -----
    Quadratic invariants are kept to rounding; energy errors of long runs grow like √t (how:
    `geomint.kernels.solve.gauss`). The map is symplectic for Hamiltonian fields on flat space. On a
    manifold such as T*S^(n−1) it is not: there a step of size h has a symplectic defect of order
    h^(2s+1): on the Hamiltonised sphere, n = 3, round-off for ``Gauss(8)`` up to h = 0.4.
    """

    stages: int = 8
    _: KW_ONLY
    iteration_tolerance: float = 0.0
    max_iterations: int = 100
    iteration: str = "auto"
    fused: bool = False

    needs = "field"
    family = "Gauss collocation"
    symmetric = True
    symplectic = True
    keeps = ("quadratic invariants",)
    references = (BUTCHER_1964, HLW_2006.at("Section II.1.3"))

    def __post_init__(self) -> None:
        stages = whole("stages", self.stages, 1, 16)
        if not (isinstance(self.iteration, str) and self.iteration in ITERATIONS):
            raise DomainError("iteration", self.iteration, f"one of {list(ITERATIONS)}")
        self._set(
            stages=stages,
            iteration_tolerance=iteration_tolerance(self.iteration_tolerance),
            max_iterations=whole("max_iterations", self.max_iterations, 1),
            fused=switch("fused", self.fused),
            name=f"gauss-{stages}",
            order=2 * stages,
            step_fraction=min(0.02 * 1.65 ** (stages - 1), 0.6),
            summary=f"Gauss collocation, {stages} stage{'s' if stages > 1 else ''}, implicit",
        )

    def flow(self, p: Posed) -> Flow:
        field, rows = p.field, p.rows
        stages, cap, tolerance = self.stages, self.max_iterations, self.iteration_tolerance
        groups = 1 if stages <= LANES else 2
        function, scratch = in_lanes(field, p)
        numbers = _lane_coefficients(stages, groups, p.lengths)
        patience = -1 if self.iteration == "fixed-point" else cap // PATIENCE
        given = {
            "rows": rows,
            "cap": 0 if self.iteration == "newton" else cap,
            "patience": patience,
            "tolerance": tolerance,
            "pieces": p.pieces,
        }
        (constant,) = unrolled(rows, limit=MAX_UNROLLED_ROWS)
        layout = gauss_coefficients(rows, groups, len(p.lengths))
        coefficients = packed(layout, **given, **numbers)

        def newton() -> Kernel:
            check_derivatives(p, field)
            at = lane_positions(stages, LANES * groups)
            return newton_kernel(
                function, rows, len(p.problem.params), scratch, at, coefficients, cap, patience
            )

        own = Kernel(
            gauss_stepper(groups, constant, function.as_helper if self.fused else None),
            () if self.fused else (function,),
            coefficients,
            sum(gauss_work(rows, groups, 8 * scratch)),
        )
        if self.iteration == "newton":
            own = newton()
        return p.flow(
            kernel=own.kernel,
            functions=own.functions,
            coefficients=own.coefficients,
            memory=gauss_memory(rows, groups),
            work=(own.work,),
            evaluations=stages,
            between=None if len(p.lengths) > 1 else _between(stages, groups),
            stages_in_lanes=True,
            ranked=True,
            newton=self.iteration == "newton",
            make_other=newton if self.iteration == "auto" else None,
        )


@functools.lru_cache(maxsize=64)
def _lane_coefficients(stages: int, groups: int, lengths: tuple[float, ...]) -> Mapping[str, Array]:
    """Return c, b, the columns of μ and of one predictor a substep, in lanes, by name."""
    table = gauss_legendre(stages)
    width = LANES * groups
    at = lane_positions(stages, width)
    return MappingProxyType(
        {
            "c": spread_vector(table.c, at, width),
            "b": spread_vector(table.b, at, width),
            "mu": spread_columns(table.mu, at, width),
            "predictors": predictor_columns(table, lengths, at, width),
        }
    )


def predictor_columns(
    table: GaussTableau | LobattoPair, lengths: tuple[float, ...], at: list[int], width: int
) -> Array:
    """Return the matrices that extrapolate to each substep, in lanes and columns.

    From the one before it, to the first from the last of the step before.
    """
    ratios = [lengths[i] / lengths[i - 1] for i in range(len(lengths))]
    nothing = np.zeros((table.stages, table.stages))
    known = [table.predictor(r) if abs(r) <= MAX_EXTRAPOLATION else nothing for r in ratios]
    return np.concatenate([spread_columns(m, at, width) for m in known])


@functools.cache
def _between(stages: int, groups: int) -> Between:
    """Return how partial steps begin: on the collocation polynomial of the whole step."""
    width = LANES * groups
    at = lane_positions(stages, width)
    powers = gauss_legendre(stages).between
    matrices = [spread_columns(m, at, width) for m in powers[::-1]]
    sums = [spread_vector(m.sum(axis=0), at, width) for m in powers]
    table = filled_block(*matrices, *sums)
    eighths = np.arange(1, 9) / 8.0
    columns = [
        spread_vector(row, at, width) for m in gauss_legendre(stages).inside(eighths) for row in m
    ]
    places = np.concatenate(
        [np.reshape(columns[8 * k : 8 * k + 8], (8, width)).T for k in range(3)]
    )
    return Between(
        gauss_between(groups),
        gauss_polynomial(groups),
        table,
        stages,
        gauss_inside(groups),
        filled_block(places),
    )


def lane_positions(stages: int, width: int) -> list[int]:
    """Return the lane of each stage: symmetric about the middle, the middle stage just before it."""
    left = (stages + 1) // 2
    return [width // 2 - left + i if i < left else width // 2 + i - left for i in range(stages)]


def spread_vector(values: Array, at: list[int], width: int) -> Array:
    """Return values at their lanes, zeros elsewhere."""
    result = np.zeros(width)
    result[at] = values
    return result


def spread_columns(matrix: Array, at: list[int], width: int) -> Array:
    """Return a matrix by columns, its rows and columns at their lanes, zeros elsewhere."""
    result = np.zeros((width, width))
    result[np.ix_(at, at)] = matrix
    return result.T.ravel()
