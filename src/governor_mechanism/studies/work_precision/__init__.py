"""Error against time of every engine."""
