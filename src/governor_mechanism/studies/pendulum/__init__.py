"""Design of pendulum governors after Zehnder."""
