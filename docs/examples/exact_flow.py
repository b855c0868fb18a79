"""
The exact flow, a billion later
===============================

Integrable motions are linear on tori. A state at τ = 10⁹ costs what one at τ = 1 costs: no steps. The
integrals are those of the beginning.
"""

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi

problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
y0 = problem.random_state(1)
exact = problem.exact(y0)
since = np.linspace(0.0, 25.0, 500)
states = exact.at_tau(1e9 + since)

figure, axes = plt.subplots(figsize=(6.5, 3.0), layout="constrained")
axes.plot(since, states[:, problem.slices["gamma"]], label=["γ₁", "γ₂", "γ₃"])
axes.set(xlabel="τ − 10⁹ (dimensionless)", ylabel="γ (dimensionless)")
axes.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
print("energy, later over at the beginning, minus 1:")
print(gi.value(problem, "energy", states[0]) / gi.value(problem, "energy", y0) - 1.0)
print(f"error of the phase, estimated: {exact.phase_error(1e9):.0e} radians")
