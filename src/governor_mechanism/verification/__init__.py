"""Comparison of the simulation with closed forms and with a user's function."""
