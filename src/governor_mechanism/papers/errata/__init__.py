"""What is not right in the four papers, found by recomputing and simulating: each place with cause and proof."""
