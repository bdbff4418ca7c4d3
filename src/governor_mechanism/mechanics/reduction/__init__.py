"""Mechanisms with one degree of freedom as functions of their coordinate."""
