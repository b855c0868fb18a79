"""
A rolling ball and its trace
============================

A ball of unequal moments of inertia rolls on a plane without slipping. Its contact point wanders
along a wavy line; in the body, the vertical γ moves on a sphere.
"""

import chaplygin as ch
import geomint as gi

ball = ch.ChaplyginSphere.from_moments([1.0, 1.5, 2.4], m=1.0, rho=1.0)
problem = ball.contact(rho=1.0)
y0 = problem.state(gamma=[0.36, 0.48, 0.8], k=[1.2, -0.9, 0.6])
sol = gi.solve(problem, y0, t_end=60.0, method="cf-4", step=0.05, dense=True)

trace = sol.plot_trace()

# %%
# The vertical, seen from the body:

sphere = sol.plot_sphere(view=gi.View(azimuth=-55, elevation=28))
