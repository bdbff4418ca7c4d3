"""Engine `multibody`: rigid bodies and joints, integrated with projection."""
