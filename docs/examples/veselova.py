"""
The Veselova problem
====================

A rigid body about a fixed point may not turn about a direction γ that is fixed in space. In the body γ
moves on a sphere; energy and K are kept to rounding.
"""

import chaplygin as ch
import geomint as gi

problem = ch.Veselova(a=[0.8, 1.1, 1.5], D=4.0).reduced()
y0 = problem.state(gamma=[0.48, 0.6, 0.64], p=[3.0, -4.0, 1.5])
sol = gi.solve(problem, y0, t_end=40.0, dense=True, observe=["energy", "K"])
for name, drift in sol.drift.items():
    print(f"{name}: off by {drift.max_rel_error:.0e} of itself at most")

sphere = sol.plot_sphere(view=gi.View(azimuth=-60, elevation=20))

# %%
# The same over time:

over_time = sol.plot("gamma", "p", span=(0, 20))
