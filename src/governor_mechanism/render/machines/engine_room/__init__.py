"""Drawing of a governed engine as an elevation of its engine room."""
