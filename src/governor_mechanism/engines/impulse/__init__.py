"""Engine `impulse`: pymunk stepped as a second-order scheme and extrapolated."""
