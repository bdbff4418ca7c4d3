"""What recomputing and simulating the four papers has found: errors, misprints and small slips, each with its proof."""
