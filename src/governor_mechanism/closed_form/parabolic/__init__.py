"""Closed forms of the astatic governor."""
