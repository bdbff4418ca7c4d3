"""Public functions of the package. Each imports what it needs on its first call, so that its module is imported quickly."""
