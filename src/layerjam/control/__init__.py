"""Control law of the vacuum, its settings, its tuning, and closed loops."""
