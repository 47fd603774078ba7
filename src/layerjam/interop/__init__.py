"""The brake in other programs: wrappers of the C kernel."""
