"""Drawing of the Proell governor."""
