"""Drawings of machines."""
