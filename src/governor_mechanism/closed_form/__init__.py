"""Cited formulas from the papers: the witness that knows nothing of the simulation."""
