"""Pictures of runs: films and figures. The rest of the package imports nothing of it."""
