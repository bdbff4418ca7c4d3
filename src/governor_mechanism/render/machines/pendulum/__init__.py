"""Drawing of pendulum governors."""
