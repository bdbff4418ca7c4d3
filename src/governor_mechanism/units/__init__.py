"""Quantities with units, and text tables."""
