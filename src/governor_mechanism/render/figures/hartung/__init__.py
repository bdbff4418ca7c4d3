"""Figures of the design of Hartung's governor."""
