"""Figures of the link motion."""
