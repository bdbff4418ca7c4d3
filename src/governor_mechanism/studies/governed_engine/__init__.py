"""Design of an engine with flywheel and Porter governor for a wanted speed, droop and speed fluctuation."""
