"""Motion of a scene under forces: what acts on it, its arrays, and its equations."""
