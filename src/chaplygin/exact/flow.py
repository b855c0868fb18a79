"""The exact flow of the Hamiltonised sphere and of Veselova's problem: states without stepping.

Both are linear in the same angles of the same tori (Theorem CH-VP (iii)), with different frequencies.
A state at any time is: angles φ₀ + ωτ, θ by Newton's method, and (γ, p̃) from θ; it costs the same at
τ = 1 and at 10⁹. Frequencies are known to more than double precision, and ωτ is reduced in two parts.
What is left of the error at large times is the rounding of the state from which the motion starts: a
relative error ε of it turns into a phase error of about condition · ω τ ε.
"""

import functools
from typing import Any

import numpy as np

import geomint as gi
from geomint.arguments import as_array

from ..initial_states import multiplier
from ..manifold import Array, length
from .angles import component_signs, linear_angles, theta_of
from .branch_points import separation_of
from .clock import Clock, Sampled, packed_clock, sampled_clock
from .clock_functions import at_time, clock_work, tau_at
from .clock_series import product_clock
from .functions import at_angles, at_tau, state_rows, state_work
from .numbers import MadeOfNumbers
from .packing import evaluated, packed_torus, start_at
from .quadrature import LEFT, Quadrature, finite_times, refuse_left_over
from .sensitivity import Estimate, frequency_gradients
from .separated_energy import SeparatedEnergy
from .symmetry import power_of_two, reduced_axes
from .torus import torus_of

MISSED = 1e-12  # of the state, by its torus


class ExactFlow(MadeOfNumbers):
    """The motion through one state, at any time.

    Made by ``problem.exact(y0)`` of a Hamiltonised or reduced problem. Call it with physical times t, a
    number or an array; `at_tau` takes times τ. Both return states of the problem from which it was
    made, flat, shape (rows,) or (times, rows). Equal a_i and motions within coordinate planes have
    tori of less dimensions, see `symmetry`.

    Parameters
    ----------
    a, D
        Of the problem.
    energy : SeparatedEnergy
    y : array, shape (2n,)
        The state at time 0.
    physical : bool
        Whether states are (γ, p), else (γ, p̃).

    Attributes
    ----------
    unit, unit_p : float
        Of the a_i and λ, and of p̃, in `axes`, `separation` and `torus`: powers of two.

    Raises
    ------
    geomint.DomainError
        For a state at rest, and motions next to a separatrix: with the condition number.
    """

    def __init__(
        self, a: Array, D: float, energy: SeparatedEnergy, y: Array, physical: bool
    ) -> None:
        self.a, self.D, self.physical, self._y0 = a, D, physical, y
        self.unit, self.unit_p = power_of_two(np.max(a)), 1.0
        gamma, p_tilde = self._split(self.inward(y))
        self.unit_p = power_of_two(np.max(np.abs(p_tilde)))
        p_tilde = p_tilde / self.unit_p
        self.axes = reduced_axes(a / self.unit, gamma, p_tilde)
        self.separation = separation_of(self.axes, gamma, p_tilde)
        energy = energy.in_units(self.unit, self.unit_p)
        self.torus = torus_of(self.separation, energy)
        if not np.isfinite(self.torus.turns).all():
            raise gi.DomainError("state", y, "a motion whose frequencies are finite numbers")
        # p = D√U p̃, and dt/dτ = D√U.
        self._rate = D / float(np.sqrt(self.unit) * np.sqrt(np.prod(self.axes.alpha)))
        scale = self.unit_p * (self._rate if physical else 1.0)
        parts = self.axes, self.separation, self.torus
        packed = packed_torus(*parts, scale, physical)
        self._params = packed.data
        found = self._begin(packed, gamma, p_tilde)
        gradients = frequency_gradients(*parts, energy, gamma, p_tilde)
        estimate = Estimate(
            float(np.max(1.0 / self.torus.strips, initial=1.0)),
            self._growth(float(np.max(gradients))),
            float(np.max(np.abs(self.frequencies))),
            self._magnified(),
        )
        self._estimate = estimate.seen(self._missed(y, found, estimate.condition))

    def _begin(self, packed: Any, gamma: Array, p_tilde: Array) -> Array:
        """Find the angles and signs of the start; return the state there, and Newton's last step."""
        position, momentum, *_ = self.axes.components(gamma, p_tilde)
        self.start = self._angles(gamma, p_tilde)
        start_at(packed, start=self.start)
        found = evaluated(at_tau, self._params, np.zeros(1), state_rows(len(gamma)), self._work)
        signs = component_signs(self.axes, position, momentum, found[:-1])
        start_at(packed, signs=signs)
        found[:-1] *= np.tile(signs @ self.axes.members, 2)
        return found

    def _missed(self, y: Array, found: Array, condition: float) -> float:
        """Return by how much the torus misses the state, or raise `DomainError`."""
        pairs = zip(np.split(self.outward(found[:-1]), 2), np.split(y, 2), strict=True)
        off = max(float(np.max(np.abs(x - z)) / np.max(np.abs(z))) for x, z in pairs)
        if not (off <= MISSED and found[-1] <= LEFT and np.isfinite(condition)):
            expected = (
                f"a motion that double precision resolves: its torus misses the state by {off:.3g}, "
                f"condition number {condition:.3g}"
            )
            raise gi.DomainError("state", y, expected)
        return off

    @property
    def frequencies(self) -> Array:
        """dφ/dτ: ω of the separated angles, then Ω of the pairs; n − 1 if all a_i are different."""
        return self.torus.frequencies

    @property
    def condition(self) -> float:
        """About what relative errors of the state are magnified by in frequencies."""
        return self._estimate.condition

    def phase_error(self, tau: Any) -> Array:
        """Return an estimate of the error of the angles at times τ, in radians.

        What the rounding of the state at time 0 makes of them, and what the computation adds: see
        `Estimate`. Errors of states, relative to their size, are no larger.
        """
        return self._estimate.phase(tau)

    def time_error(self, tau: Any) -> Array:
        """Return an estimate of the error of physical time at times τ, as an angle in radians.

        What is missing from the Fourier series of dt/dτ, as if it were of one sign.
        """
        times = np.abs(np.asarray(tau, dtype=np.float64))
        return self.clock.edge * self._estimate.fastest * times

    @property
    def longest(self) -> float:
        """The largest |τ| for which the phase means something: `phase_error` is below a radian."""
        return self._estimate.longest

    def _magnified(self) -> float:
        """Return how many times larger roundings of the state are in (γ, p̃)."""
        return 1.0

    def _growth(self, steepest: float) -> float:
        """Return g of `Estimate` from the gradient of the most sensitive frequency: that."""
        return steepest

    def rate(self, states: Array) -> Array:
        """Return dt/dτ = D√U of states, shape (..., rows) ↦ (...,)."""
        gamma = self.inward(np.asarray(states))[..., : len(self.a)]
        return self.D * np.sqrt(np.sum(gamma * gamma / self.a, axis=-1))

    @property
    def clock(self) -> Clock:
        """Physical time as a function of τ; what refuses it once refuses it at once ever after."""
        if isinstance(self._clock, gi.GeomintError):
            raise self._clock.with_traceback(None)
        return self._clock

    @functools.cached_property
    def _clock(self) -> Clock | gi.GeomintError:
        try:
            return self._make_clock()
        except gi.GeomintError as refusal:
            return refusal

    def _make_clock(self) -> Clock:
        return product_clock(self.torus, self._rate, lambda phi: self.rate(self.at_angles(phi)))

    @property
    def mean_frequencies(self) -> Array:
        """Mean frequencies in physical time, `frequencies`/T."""
        return self.frequencies / self.clock.mean

    @np.errstate(over="ignore", invalid="ignore")
    def angles(self, y: Any) -> Array:
        """Return (φ, Φ) of a state on the torus, modulo 4π, shape of `frequencies`."""
        result = self._angles(*self._split(self.inward(self._state(y))))
        if not np.isfinite(result).all():
            raise gi.DomainError("y", y, "a state on the torus")
        return result

    @property
    def ovals(self) -> Array:
        """The ends of the intervals in which the λ_k run to and fro, shape (d, 2)."""
        ends = [[oval.lower, oval.upper] for oval in self.separation.ovals]
        return self.unit * np.array(ends).reshape(-1, 2)

    def theta(self, y: Any) -> Array:
        """Return θ_k in [−π, π] of a state, shape (d,); see `lam`."""
        components = self.axes.components(*self._split(self.inward(self._state(y))))
        return theta_of(self.axes, self.torus, *components[:2])

    def lam(self, theta: Any) -> Array:
        """Return λ_k = m_k − d_k cos θ_k, shape (..., d)."""
        return self.unit * (self.torus.middle - self.torus.radius * np.cos(theta))

    def at_tau(self, tau: Any) -> Array:
        """Return states at times τ, of any sign, |τ| up to `longest`.

        Raises
        ------
        geomint.DomainError
            For times that are not finite, and beyond `longest`.
        geomint.ConvergenceError
            If an iteration fails: never seen where the torus could be made.
        """
        return self._states(
            at_tau, self._params, self._work, finite_times("tau", tau, self.longest)[..., None]
        )

    def __call__(self, t: Any) -> Array:
        """Return states at physical times t, of any sign; errors as `at_tau`."""
        return self._states(at_time, self._timed, self._clock_work, self._physical_times(t))

    def at_angles(self, phi: Any) -> Array:
        """Return states at angles (φ, Φ), shape (..., angles); those of pairs may be left out: 0."""
        given = as_array("phi", phi, "real numbers")
        if not np.isfinite(given).all():
            raise gi.DomainError("phi", phi, "finite angles")
        if given.ndim == 0 or given.shape[-1] > len(self.start):
            expected = f"an array whose last axis has no more than {len(self.start)} angles"
            raise gi.DomainError("phi", phi, expected)
        full = np.zeros((*given.shape[:-1], len(self.start)))
        full[..., : given.shape[-1]] = np.remainder(given, 4.0 * np.pi)
        return self._states(at_angles, self._params, self._work, full)

    def time(self, tau: Any) -> Array:
        """Return physical time at times τ."""
        return Quadrature(self.clock, self._timed, self._clock_work, self.longest)(tau)

    def tau(self, t: Any) -> Array:
        """Return τ at physical times t; errors as `at_tau`."""
        points = self._physical_times(t)
        values = evaluated(tau_at, self._timed, points, 2, self._clock_work)
        refuse_left_over(values[..., 1], points)
        return values[..., 0]

    def inward(self, y: Array) -> Array:
        """Return the flow's own states (γ, p) or (γ, p̃) of states of the problem: these."""
        return y

    def outward(self, y: Array) -> Array:
        """Return states of the problem of the flow's own: these."""
        return y

    def quadrature(self, rate: Sampled) -> Quadrature:
        """Return ∫ rate dτ along the motion, of a function of φ that need not be of one sign.

        Parameters
        ----------
        rate : callable
            Of φ, shape (N, d) ↦ (N,), of period 4π in every angle.

        Raises
        ------
        geomint.DomainError
            For more than two separated angles, and a function whose Fourier series does not decay.
        """
        clock = sampled_clock(self.torus, rate, 2, signed=True)
        params = np.concatenate([self._params, packed_clock(clock, self.torus, self.start)])
        return Quadrature(clock, params, self._clock_rows(clock), self.longest)

    def _physical_times(self, t: Any) -> Array:
        longest = min(self.longest * abs(self.clock.mean), np.finfo(np.float64).max)
        return finite_times("t", t, longest)[..., None]

    @functools.cached_property
    def _timed(self) -> Array:
        timed = packed_clock(self.clock, self.torus, self.start)
        return np.concatenate([self._params, timed])

    @property
    def _work(self) -> int:
        return len(self.start) + state_work(len(self.torus.middle), len(self.start))

    @functools.cached_property
    def _clock_work(self) -> int:
        return self._clock_rows(self.clock)

    def _clock_rows(self, clock: Clock) -> int:
        bounds = int(np.sum(np.max(np.abs(clock.waves), axis=0, initial=0)))
        return clock_work(len(self.torus.middle), len(self.start), bounds)

    def _states(self, function: Any, params: Array, work: int, points: Array) -> Array:
        n = len(self.a)
        values = evaluated(function, params, points, state_rows(n), work)
        refuse_left_over(values[..., -1], points)
        return self.outward(values[..., : 2 * n])

    def _state(self, y: Any) -> Array:
        return gi.as_vector("y", y, 2 * len(self.a))

    def _split(self, y: Array) -> tuple[Array, Array]:
        """Return γ and p̃, in its unit, of one of the flow's own states."""
        n = len(self.a)
        gamma = y[:n] / length(y[:n])
        scale = multiplier(self.a, self.D, gamma) if self.physical else 1.0
        return gamma, y[n:] / scale / self.unit_p

    def _angles(self, gamma: Array, p_tilde: Array) -> Array:
        position, momentum, psi, _ = self.axes.components(gamma, p_tilde)
        theta = theta_of(self.axes, self.torus, position, momentum)
        return linear_angles(self.torus, theta, psi)
