"""The drawing of mechanisms that have none of their own."""
