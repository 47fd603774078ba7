"""All figures, and reports of measurements."""
