"""Figures of Hartung's governor."""
