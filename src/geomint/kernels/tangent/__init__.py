"""Directions carried along by steps: what the derivative of a numerical flow does to volumes."""
