"""The brake in other programs, as wrappers of the C kernel."""
