"""The paper reproduced: every claim with the result computed here."""
