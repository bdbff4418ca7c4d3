"""Plates of a run, by machine, in the style of old engravings."""
