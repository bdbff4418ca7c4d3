"""Studies of the regulation by a governor."""
