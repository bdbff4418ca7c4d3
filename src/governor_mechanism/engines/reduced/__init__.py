"""Engine `reduced`: one coordinate, integrated along tables."""
