"""All drawing, and the reproduction of the paper."""
