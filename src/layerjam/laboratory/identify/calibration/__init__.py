"""Calibration: the parameters of a brake from pulls, with intervals and checks."""
