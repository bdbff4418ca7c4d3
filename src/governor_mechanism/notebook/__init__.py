"""What a notebook shows: tables of runs and scenes, and films."""
