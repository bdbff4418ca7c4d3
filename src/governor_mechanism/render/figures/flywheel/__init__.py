"""Figures of the flywheel of the air-expansion engine."""
