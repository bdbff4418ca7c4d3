"""Physical effects, one file each: parameters and their checks."""
