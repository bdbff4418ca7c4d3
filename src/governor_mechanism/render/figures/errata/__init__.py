"""Figures of the errata: one for the main error of each paper, and each says one thing."""
