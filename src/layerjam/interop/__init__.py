"""The brake in other programs: what wraps the C kernel."""
