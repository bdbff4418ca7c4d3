"""Numerical methods that know no mechanism."""
