"""The vacuum line that evacuates the brake, and its speed."""
