"""Quantities computed from states: readings, energy, work, reactions, turning points."""
