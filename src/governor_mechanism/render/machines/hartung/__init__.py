"""The drawing of Hartung's governor."""
