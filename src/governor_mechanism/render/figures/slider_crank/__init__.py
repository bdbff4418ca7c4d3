"""Figures of the slider crank."""
