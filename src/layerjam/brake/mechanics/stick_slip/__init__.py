"""Stick–slip of a mass on a spring."""
