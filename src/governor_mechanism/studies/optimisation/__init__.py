"""Optimisation of the dimensions of a scene."""
