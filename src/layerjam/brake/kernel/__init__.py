"""The brake's law as a small C kernel for fast stepping."""
