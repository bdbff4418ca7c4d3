"""Couplings between parts, and the parts of a scene as one mechanism."""
