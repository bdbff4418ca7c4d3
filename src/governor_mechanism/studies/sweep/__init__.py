"""Sweeps over the keys of a scene."""
