"""Studies of how a governor regulates."""
