"""Equations of motion of a scene as arrays."""
