"""A reproduction of the paper: every claim, with the result computed here."""
