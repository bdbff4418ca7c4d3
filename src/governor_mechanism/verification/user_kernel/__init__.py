"""The simulation against a user's function: its quantities, samples, calls and report."""
