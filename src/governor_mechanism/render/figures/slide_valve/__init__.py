"""Plates of slide valves by Zeuner and Marks."""
