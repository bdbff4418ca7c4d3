"""Machines: dimensions in, Mechanism out."""
