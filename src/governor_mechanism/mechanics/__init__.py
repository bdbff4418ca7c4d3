"""Kinematics, dynamics, reduction to one coordinate, and contact."""
