"""Fit of unknown values of a scene to measured readings."""
