"""Plate of the bearing loads of a slider crank."""
