"""Shapes in metres."""
