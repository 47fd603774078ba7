"""Bayesian calibration."""
