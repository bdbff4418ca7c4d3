"""Drawing of slide-valve engines."""
