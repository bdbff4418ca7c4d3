"""Contact: rules, impacts, transitions, the contacts of a scene, tolerances, and comparison of events."""
