"""What a run and the analyses return: frozen values, with methods that hand on to later folders."""
