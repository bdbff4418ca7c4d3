"""What recomputing and simulating the four papers has found: errors, misprints and slips of rounding, each with its proof."""
