"""Measurements: readers for file formats, selection of columns, sidecars and traces."""
