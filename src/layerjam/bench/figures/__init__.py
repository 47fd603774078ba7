"""Figures of closed loops, lines and wiring."""
