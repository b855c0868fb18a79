"""The symplectic form that the flow of a problem keeps."""

from dataclasses import dataclass

from ..kernels.compiling.recorded import Recorded, helper
from ..kernels.compiling.sending import Sendable
from .forms import check_recorded, check_types


@helper
def canonical_form(params, t, y, u, v, work):
    """Return dq∧dp (u, v) = Σ_i u_qi v_pi − u_pi v_qi on states (q, p)."""
    n = len(y) // 2
    total = 0.0 * u[0]
    for i in range(n):
        total += u[i] * v[n + i] - u[n + i] * v[i]
    return total


@dataclass(frozen=True, eq=False)
class SymplecticForm(Sendable):
    """A closed two-form ω on the manifold of states that the flow keeps, in the problem's own time.

    The manifold is that of the problem's measure; vectors are tangent to it. The form need not be the
    canonical one: ρ(q) dq∧dp, forms with magnetic terms and those of other coordinates are functions
    of the state. Forms that the flow only multiplies by a number are not meant.

    Parameters
    ----------
    form : recorded ``f(params, t, y, u, v, work) -> number``
        ω_y(u, v), linear in u and in v. Default: Σ_i u_qi v_pi − u_pi v_qi, of states (q, p).
    constant : bool
        Whether it is the same at every state.
    """

    form: Recorded = canonical_form
    constant: bool = True

    def __post_init__(self) -> None:
        check_recorded(self, "form")
        check_types(self, {"constant": bool})
