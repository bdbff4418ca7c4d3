"""Machines designed by the procedures of papers and textbooks."""
