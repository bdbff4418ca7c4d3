"""Zehnder's plate of isochronous parabolas."""
