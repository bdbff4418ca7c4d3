"""Scenes with a mechanism of the user: bodies, joints, force elements."""
