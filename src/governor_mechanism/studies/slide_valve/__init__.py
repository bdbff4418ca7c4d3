"""Studies of the slide valve."""
