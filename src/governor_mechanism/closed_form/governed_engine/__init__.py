"""Closed forms of engines whose speed a governor controls."""
