"""What one measured pull shows."""
