"""What a file says: readers (one a format), one taker of columns, sidecars, traces."""
