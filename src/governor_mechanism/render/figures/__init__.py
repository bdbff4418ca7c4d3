"""Figures of runs and studies as PNG files."""
