"""The brake in other programs, through wrappers of the C kernel."""
