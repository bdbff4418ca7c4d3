"""Plate of slide valves by Marks."""
