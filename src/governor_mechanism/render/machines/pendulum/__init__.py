"""The drawing of the pendulum governors."""
