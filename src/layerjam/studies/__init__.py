"""Applications of the library: a reproduction of the paper, and four machines."""
