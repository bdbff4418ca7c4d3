"""Drawing of any mechanism that moves a slide valve, with the engine that it serves."""
