"""Stop of a mass by the brake: exact at constant vacuum, and integrated in time."""
