"""Drawing of Stephenson's link motion."""
