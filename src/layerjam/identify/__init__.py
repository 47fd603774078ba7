"""What measurements mean: friction, pulls, calibration, validation, rubber, logs."""
