"""What to make: film patterns, printed parts, a mould, a parts list, and whether it can be made."""
