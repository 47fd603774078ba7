"""Time logs: pressure, acceleration, a vacuum history."""
