"""Studies of the link motion."""
