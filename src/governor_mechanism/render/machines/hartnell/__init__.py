"""Drawing of the Hartnell governor."""
