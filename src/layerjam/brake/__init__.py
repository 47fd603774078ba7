"""The brake: what it is, and how it behaves."""
