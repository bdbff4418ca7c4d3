"""Generic drawing of any mechanism."""
