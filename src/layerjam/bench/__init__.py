"""The bench: the vacuum on hardware, real or virtual."""
