"""Control law of the vacuum, with its settings, its tuning and closed loops."""
