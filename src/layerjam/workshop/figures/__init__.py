"""Figures of designs, and drawings of parts and assembly."""
