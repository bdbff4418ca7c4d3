"""What a scene is and what a run returns: frozen values, no mathematics."""
