"""Calibration with probabilities."""
