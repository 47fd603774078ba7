"""Analysis of friction tests."""
