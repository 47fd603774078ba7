"""Figures of measurements, and the report of a brake."""
