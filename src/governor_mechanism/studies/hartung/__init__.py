"""The design of Hartung's governor."""
