"""Hartung's spring governor."""
