"""Figures of the slide valve."""
