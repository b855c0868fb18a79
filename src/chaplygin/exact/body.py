"""The exact flow of the classical Veselova problem, n = 3, at any f₁.

The body's tori are those of a ball (`chaplygin.correspondence.maps`): with c𝓘 for 𝓘, whose motions
are the same, c so large that all c𝓘_i > 1, that ball has the moments I = D/(c𝓘 − 1), and

    k⃗_ball = −(ck⃗ + (1 − c) f₁γ⃗),   the same γ⃗.

The two *flows* on a torus are different. But both have the same density (γ⃗, 𝓘⁻¹γ⃗)^(−1/2), and in the
ball's angles φ the body's flow is linear too, after the same change of time, dt/ds = dt_ball/dτ. The
paper has that for f₁ = 0, Theorem CH-VP (iii); that it holds at any f₁ was found here, to 12 digits for
random bodies, states and f₁ (tests).

So the flow in s is that of an energy ½(x F(0) + y (p̃, Ap̃)) of the ball without area constant to which
the torus belongs. F(0) is U (p̃, p̃), and x = 0 only for f₁ = 0; x and y follow from the velocities of
γ⃗ at some states of the torus.
"""

import numpy as np

import geomint as gi

from ..inertia import SpecialInertia
from ..manifold import Array
from .classical import BallFlow, ExactBall
from .separated_energy import SeparatedEnergy
from .torus import frequencies_on

STATES = 12  # on the torus, from which x and y are computed
TOLERANCE = 1e-6  # of the velocities
SMALLEST = 1e-16  # of singular values
ROUNDINGS = 8.0  # in a velocity: of γ⃗₁, p₁, w⃗, dt/ds


class ExactBody(BallFlow):
    """The motion of the classical Veselova problem through one state (k⃗, γ⃗), at any time.

    Made by ``problem.exact(y0)``. Call it with physical times; `at_tau` takes times s. Angles are those
    of the ball without area constant.

    Parameters
    ----------
    inverse : array, shape (3,)
        1/𝓘_i.
    f1 : float
        (w⃗, γ⃗).
    y : array, shape (6,)
        The state at time 0.

    Raises
    ------
    geomint.DomainError
        As `ExactFlow`; where k⃗ and γ⃗ are parallel.
    """

    def __init__(self, inverse: Array, f1: float, y: Array) -> None:
        self._inverse, self._f1 = inverse, f1
        self._c = 2.0 * float(np.max(inverse))
        moments = 1.0 / (self._c / inverse - 1.0)
        ball = SpecialInertia.from_moments(moments, 1.0)
        self._ball = ExactBall(ball, ball.D, self._of_ball(y))
        super().__init__(self._ball.a, self._ball.D, self._energy(), y, True)

    def _magnified(self) -> float:
        return self._ball._magnified()

    def _growth(self, steepest: float) -> float:
        """Return that of the ball, and what errors of the energy make of the frequencies."""
        return self._ball._growth(steepest) + self._sensitivity

    def rate(self, states: Array) -> Array:
        """Return dt/ds of states (k⃗, γ⃗), shape (..., 6) ↦ (...,)."""
        return self._ball.rate(self._of_ball(states))

    def angular_velocity(self, y: Array) -> Array:
        """Return w⃗ = B(k⃗ + mγ⃗) of states, shape (..., 3), in the body."""
        k, gamma = y[..., :3], y[..., 3:]
        turning = np.sum(gamma * self._inverse * k, axis=-1)
        weight = np.sum(gamma * self._inverse * gamma, axis=-1)
        m = (np.sum(k * gamma, axis=-1) - turning) / weight
        return self._inverse * (k + m[..., None] * gamma)

    def inward(self, y: Array) -> Array:
        """Return (γ₁, p₁) of the ball with area constant zero from (k⃗, γ⃗)."""
        return self._ball.inward(self._of_ball(np.asarray(y)))

    def outward(self, y: Array) -> Array:
        """Return (k⃗, γ⃗) from (γ₁, p₁) of the ball with area constant zero."""
        state = self._ball.outward(y)
        k, gamma = state[..., :3], state[..., 3:]
        own = (-k - (1.0 - self._c) * self._f1 * gamma) / self._c
        return np.concatenate([own, gamma], axis=-1)

    def _of_ball(self, y: Array) -> Array:
        """Return (k⃗, γ⃗) of the ball from that of the body."""
        k, gamma = y[..., :3], y[..., 3:]
        return np.concatenate([-(self._c * k + (1.0 - self._c) * self._f1 * gamma), gamma], axis=-1)

    def _energy(self) -> SeparatedEnergy:
        """Return x and y: γ⃗₁ moves with the body's w⃗ as with the flow of that energy."""
        ball = self._ball
        rng = np.random.default_rng(1)
        phi = rng.uniform(0.0, 4.0 * np.pi, (STATES, len(ball.start)))
        first = ball.inward(ball.at_angles(phi))
        own = self.outward(first)
        gamma, p = first[:, :3], first[:, 3:]
        size = float(np.max(np.abs(p)))  # of which squares are numbers
        velocity = np.cross(gamma, self.angular_velocity(own) / size) * self.rate(own)[:, None]
        u = np.sum(gamma * gamma / ball.a, axis=-1, keepdims=True)
        p_tilde = p / size / (ball.D * np.sqrt(u))
        # ∂/∂p̃ of ½U(p̃, p̃) and ½(p̃, Ap̃), along the sphere.
        steep = ball.a * p_tilde
        steep -= np.sum(steep * gamma, axis=-1, keepdims=True) * gamma
        columns = np.stack([u * p_tilde, steep], axis=-1).reshape(-1, 2)
        sizes, scale = np.linalg.norm(columns, axis=0), np.linalg.norm(velocity)
        columns /= sizes
        weights = np.linalg.lstsq(columns, velocity.reshape(-1), rcond=SMALLEST)[0]
        left = float(np.linalg.norm(columns @ weights - velocity.reshape(-1)) / scale)
        # What roundings of the velocities do to the frequencies, by the direction of the worst weights.
        _, singular, directions = np.linalg.svd(columns, full_matrices=False)
        worst = directions[-1] * scale / max(singular[-1], SMALLEST * singular[0]) / sizes
        changed = SeparatedEnergy(float(worst[0]), float(worst[1])).in_units(ball.unit, ball.unit_p)
        rates = frequencies_on(ball.separation, changed)
        self._sensitivity = ROUNDINGS * float(np.max(np.abs(rates)))
        if not left < TOLERANCE:
            expected = (
                "a state whose k and gamma are less parallel: the body's flow on its torus cannot be "
                f"distinguished from others: the velocities are off by {left:.3g}"
            )
            raise gi.DomainError("state", own[0], expected)
        weights = weights / sizes
        return SeparatedEnergy(float(weights[0]), float(weights[1]))
