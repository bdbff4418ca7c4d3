"""Closed forms of pendulum governors."""
