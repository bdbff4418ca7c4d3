"""A run as one interactive HTML page."""
