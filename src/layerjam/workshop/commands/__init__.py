"""Commands that show, compare, design and build brakes."""
