"""Rules about governing from the papers, each against simulations of the governed engine."""
