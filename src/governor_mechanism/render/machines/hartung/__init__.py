"""Drawing of Hartung's governor."""
