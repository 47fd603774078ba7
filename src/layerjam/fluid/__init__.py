"""The vacuum line: what brings the vacuum into the brake, and how fast."""
