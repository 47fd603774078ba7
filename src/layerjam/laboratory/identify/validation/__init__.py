"""Comparison of the model with measured pulls."""
