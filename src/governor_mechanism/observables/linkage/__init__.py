"""What kinematics says of a whole linkage: its mobility, its four-bar loops, its travel with dead centres and toggles."""
