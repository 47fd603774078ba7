"""The vacuum line, which evacuates the brake, and its speed."""
