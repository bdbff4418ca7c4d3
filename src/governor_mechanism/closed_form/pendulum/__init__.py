"""Closed forms of the pendulum governors."""
