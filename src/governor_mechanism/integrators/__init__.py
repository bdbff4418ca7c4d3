"""Integration of first-order equations with events and projection."""
