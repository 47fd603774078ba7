"""Which sheet slides when: the stack, sheet by sheet."""
