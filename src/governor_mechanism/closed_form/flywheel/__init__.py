"""The flywheel of Redtenbacher's air-expansion engine: pressures and stored work, angles of extreme speed, the wheel."""
