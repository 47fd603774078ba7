"""A mass on a spring that sticks and slips."""
