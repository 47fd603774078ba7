"""Readers for files of test machines, recognised by their content."""
