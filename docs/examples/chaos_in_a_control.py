"""
Chaos where the theory does not apply
=====================================

A ball without momentum in four dimensions. With the special inertia operator it is integrable:
neighbours part in proportion to time. With another operator there still is an invariant measure, but
no Chaplygin multiplier, and here neighbours part exponentially.
"""

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi

other = ch.GeneralInertia([1.0, 4.0, 0.3, 2.0, 0.1, 3.0])
balls = {"special": ch.ChaplyginSphere(a=[0.2, 0.5, 0.8, 1.1], D=1.0)}
balls["another"] = ch.ChaplyginSphere(inertia=other, D=1.0)
times = np.linspace(0.0, 200.0, 401)
figure, axes = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
for name, ball in balls.items():
    problem = ball.reduced()
    y0, aside = problem.random_state(3), np.zeros(8)
    aside[4:] = np.eye(4)[0] - y0[0] * y0[:4]  # a momentum orthogonal to γ
    states = (y0, y0 + 1e-9 * aside)
    one, two = (gi.solve(problem, y, t_end=200.0, t_eval=times, step=0.05).y for y in states)
    axes.semilogy(times, np.linalg.norm(one - two, axis=1), label=f"{name} operator")
axes.set(xlabel="time t (dimensionless)", ylabel="distance of two motions")
legend = axes.legend()
