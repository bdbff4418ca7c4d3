"""Mechanisms composed in Python: bodies, joints and forces become the document of a scene with a custom machine."""
