"""Comparison of governors, or of any scenes: statics and runs side by side."""
