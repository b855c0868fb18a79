"""
In SciPy's solve_ivp
====================

A pendulum, 1000 units of time, by `solve_ivp`: with SciPy's own method, and with a symplectic one of
`geomint.scipy` at a fixed step. It evaluates the field more often, and its error does not grow.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import geomint as gi


def pendulum(t, y):
    return np.array([y[1], -np.sin(y[0])])


figure, axes = plt.subplots(figsize=(6.5, 3.0), layout="constrained")
for method, given in (("DOP853", {"rtol": 1e-6}), (gi.scipy.GAUSS4, {"step": 0.5})):
    sol = solve_ivp(pendulum, (0, 1000), [2.0, 0.0], method=method, **given)
    energy = sol.y[1] ** 2 / 2 - np.cos(sol.y[0])
    name = f"{getattr(method, '__name__', method)}, {sol.nfev} evaluations"
    axes.semilogy(sol.t[1:], abs(energy - energy[0])[1:], label=name)
axes.set(xlabel="time t (dimensionless)", ylabel="|H − H₀| (dimensionless)")
legend = axes.legend()
