"""Reading of measurements: readers for the formats, column selection, sidecars, traces."""
