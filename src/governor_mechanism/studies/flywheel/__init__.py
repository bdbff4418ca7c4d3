"""Design of the flywheel of Redtenbacher's air-expansion engine."""
