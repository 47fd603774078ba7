"""Simulations: procedures run on a brake, and their records."""
