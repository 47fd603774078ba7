"""All drawing, and pages of measurements."""
