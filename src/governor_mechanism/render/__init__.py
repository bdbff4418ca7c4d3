"""Pictures of runs: films and figures. Nothing here is imported by the rest of the package, and nothing here computes."""
