"""Closed forms of the isochronous parabola."""
