"""Contact tolerances, impact, and comparison of events."""
