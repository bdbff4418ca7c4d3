"""Engine with expansion cylinder, pump and flywheel."""
