"""Records of a brake: sheets, film, enclosure, mount and rope, with the source of each value."""
