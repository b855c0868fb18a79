"""
A frequency map
===============

The ratio of the two frequencies of the torus through each of 121 states with γ on a line and p̃ of
one length. It is smooth but for where the line crosses a separatrix.
"""

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch

problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
angles = np.linspace(0.05, np.pi / 2 - 0.05, 121)
states = []
for angle in angles:
    gamma = np.array([np.cos(angle), 0.0, np.sin(angle)])
    across = np.array([-np.sin(angle), 0.0, np.cos(angle)])
    states.append(problem.state(gamma=gamma, p_tilde=0.6 * across + np.array([0.0, 0.8, 0.0])))
found = ch.frequency_map(problem, states)

figure, axes = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
axes.plot(np.degrees(angles), found.rotation_numbers[:, 0], ".-")
label = axes.set(xlabel="angle of γ from the first axis (degrees)", ylabel="ω₂/ω₁")
