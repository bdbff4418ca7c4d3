"""Public functions of the package. Each imports what it needs on its first call, since that is slow to import."""
