"""
Brouwer's law
=============

What is left where a method is exact to rounding: the energy's error is a random walk, in proportion
to √t. Ten states, 100 000 steps each.
"""

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi

problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
errors = []
for seed in range(10):
    given = {"method": "gauss-8", "step": 0.1, "save_every": 1000, "clock": False}
    sol = gi.solve(problem, problem.random_state(seed), tau_end=10_000.0, **given)
    energies = np.array([gi.value(problem, "energy", y) for y in sol.y])
    errors.append(energies / energies[0] - 1.0)

figure, axes = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
axes.loglog(sol.tau[1:], abs(np.array(errors)).T[1:], color="0.75", linewidth=0.6)
axes.loglog(sol.tau[1:], np.sqrt(np.mean(np.square(errors), axis=0))[1:], label="root mean square")
axes.loglog(sol.tau[1:], 1e-17 * np.sqrt(sol.tau[1:] / 0.1), "k--", label="10⁻¹⁷ √steps")
axes.set(xlabel="time τ (dimensionless)", ylabel="|H/H₀ − 1|", ylim=(1e-17, 1e-13))
legend = axes.legend()
