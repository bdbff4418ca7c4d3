"""Stephenson's link motion."""
