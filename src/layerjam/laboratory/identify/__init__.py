"""Analysis of measurements: friction, pulls, calibration, validation, rubber and logs."""
