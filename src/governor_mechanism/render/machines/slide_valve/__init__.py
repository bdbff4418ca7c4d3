"""The drawing of the slide valve."""
