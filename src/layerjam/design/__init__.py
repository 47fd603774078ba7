"""What to build: arrays of brakes, and what could be bought instead."""
