"""Commands that read tests, calibrate, report and publish."""
