"""Holonomic systems that the nonholonomic ones become under a change of variables and time."""
