"""Synthesis of four-bar linkages: dimensions for wanted angles, positions of a body, or a path of a point."""
