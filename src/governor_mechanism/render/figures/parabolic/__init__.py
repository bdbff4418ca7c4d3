"""Figures of the astatic governor."""
