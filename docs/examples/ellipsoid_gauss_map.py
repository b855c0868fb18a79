"""
Geodesics and the Gauss map
===========================

A free particle on an ellipsoid, and the normal of the ellipsoid where it is: on the sphere, up to a
change of time, the normal moves as γ does in a Veselova problem (Knörrer, Fedorov and Jovanović).
"""

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi

a = [1.0, 2.0, 4.0]
change = ch.gauss_map(a)
geodesics, veselova = change.source, change.target
y0 = geodesics.random_state(3)
sol = gi.solve(geodesics, y0, t_end=60.0, t_eval=np.linspace(0, 60, 3000))
normals = np.array([change.forward(y)[:3] for y in sol.y])

figure, axes = plt.subplots(1, 2, figsize=(6.5, 3.2), subplot_kw={"projection": "3d"})
for ax, points, name in zip(axes, (sol.piece("x"), normals), "xγ", strict=True):
    ax.plot(*points.T, linewidth=0.6)
    ax.set(xlabel=f"{name}₁", ylabel=f"{name}₂", zlabel=f"{name}₃", aspect="equal")
    ax.locator_params(nbins=3)
axes[0].set_title("geodesic on the ellipsoid")
title = axes[1].set_title("its normal: a Veselova motion")
