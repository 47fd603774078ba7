"""A package that adds to layerjam what only one laboratory needs."""
