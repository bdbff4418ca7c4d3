"""Drawing of an engine with a flywheel."""
