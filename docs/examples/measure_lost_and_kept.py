"""
An invariant measure, kept and lost
===================================

The flow of the Hamiltonised sphere keeps the volume of phase space. Watched along a run: log of the
volume that a small cloud of states has gained or lost. RATTLE keeps it to the noise of the instrument,
Gauss methods up to an oscillation; the Runge–Kutta method loses it in proportion to time.
"""

import matplotlib.pyplot as plt

import chaplygin as ch
import geomint as gi

problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
figure, axes = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
for method in ("rk-4", "gauss-2", "rattle-4"):
    given = {"method": method, "step": 0.05, "observe": ["measure"]}
    sol = gi.solve(problem, problem.random_state(1), tau_end=500.0, **given)
    times, _, largest = sol.drift["measure"].windows.closed
    axes.loglog(times, largest, label=method)
axes.set(xlabel="time τ (dimensionless)", ylabel="|log of the volume's ratio|")
legend = axes.legend(ncols=2)
