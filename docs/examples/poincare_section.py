"""
A Poincaré section
==================

Where γ₃ passes zero upwards, six motions of one energy of the reduced Chaplygin sphere, n = 3. It is
integrable: every motion stays on a closed curve.
"""

import geomint as gi
from geomint.run.level import states_on_level

scene = gi.load_scene("sphere-n3")
others = states_on_level(scene.problem, scene.state, 5, keep=["energy"])
states = [scene.state, *others]
points = gi.poincare_section(scene.problem, states, gi.Event("gamma[2]", "up"), 150)

figure = points.plot()
