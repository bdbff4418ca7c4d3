"""Equilibria and the speed curve."""
