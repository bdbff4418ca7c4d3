"""Checks of Hartung's governor."""
