"""Closed forms of Hartung's governor."""
