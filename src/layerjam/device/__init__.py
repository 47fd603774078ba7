"""What the brake is: sheets, film, enclosure, mount, rope, and where each number comes from."""
