"""The pendulum governors of Watt and Porter."""
