"""Users of the library: the paper reproduced, and four machines."""
