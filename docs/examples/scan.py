"""
A scan over two parameters
==========================

A parameter of the system by an initial angle: 625 runs, side by side in the lanes and cores of the
machine. The colour is the main frequency of γ₃, read off every run as it goes along.
"""

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi

values, angles = np.linspace(2.0, 6.0, 25), np.linspace(0.1, 1.4, 25)
problems, states = [], []
for D in values:
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=D).hamiltonized()
    for x in angles:
        problems.append(problem)
        states.append(problem.state(gamma=[np.cos(x), 0, np.sin(x)], p_tilde=[0, 1, 0]))
many = gi.solve_ensemble(problems, states, tau_end=250.0, readings=["frequency:gamma[2]"])

figure, axes = plt.subplots(figsize=(5.0, 3.6), layout="constrained")
rates = many.readings["frequency:gamma[2]"].reshape(25, 25)
image = axes.pcolormesh(np.degrees(angles), values, rates, cmap="cividis")
axes.set(xlabel="angle of γ from the first axis (degrees)", ylabel="D (dimensionless)")
bar = figure.colorbar(image, label="frequency of γ₃ in τ")
