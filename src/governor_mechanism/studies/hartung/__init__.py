"""Design of Hartung's governor after Dubois."""
