"""Each machine against its closed forms."""
