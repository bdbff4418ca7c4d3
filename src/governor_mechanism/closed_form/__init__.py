"""Cited formulas: an independent check of the simulation."""
