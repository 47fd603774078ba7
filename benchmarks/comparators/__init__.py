"""The same drops, solved by what a user would pick instead: one file for each neighbour."""
