"""Figures of predictions, and of the brake itself."""
