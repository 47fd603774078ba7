"""The brake in other programs: one C kernel, and what wraps it."""
