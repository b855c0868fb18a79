"""Plots of drifts, and the style of all plots."""
