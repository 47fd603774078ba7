"""The brake's law as a small kernel in C for fast stepping."""
