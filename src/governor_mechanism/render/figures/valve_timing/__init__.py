"""Plates of any valve whose displacement follows from a crank."""
