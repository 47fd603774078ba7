"""The brake's law once more, as a small kernel in C that steps it fast."""
