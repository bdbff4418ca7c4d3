"""Design of Hartnell governors."""
