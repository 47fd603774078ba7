"""A mass that the brake stops: exactly at constant vacuum, and marched in time."""
