"""Drawings of machines: shapes in metres, without colours."""
