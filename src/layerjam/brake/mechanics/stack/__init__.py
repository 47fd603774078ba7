"""The stack sheet by sheet: which sheet slides at which elongation."""
