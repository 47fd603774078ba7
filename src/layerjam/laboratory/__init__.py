"""Measurements: what tests say about a brake."""
