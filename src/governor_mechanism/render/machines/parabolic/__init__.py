"""Drawing of the parabolic governor."""
