"""The mathematics of joints, loads and readings, on arrays."""
