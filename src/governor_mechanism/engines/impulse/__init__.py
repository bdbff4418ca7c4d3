"""Impulse engine: fixed steps on pymunk, with Richardson extrapolation."""
