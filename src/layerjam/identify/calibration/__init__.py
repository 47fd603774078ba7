"""Calibration: the numbers of a brake from pulls, with intervals and checks."""
