"""A scene lowered to arrays: bodies, constraint rows, event functions."""
