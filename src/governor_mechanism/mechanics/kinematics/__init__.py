"""Positions and velocities of mechanisms; no forces."""
