"""All configurations in which the joints of a mechanism close at given drives."""
