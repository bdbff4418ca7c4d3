"""Contact: rules, transitions, the contacts of a scene, tolerances, and comparison of events."""
