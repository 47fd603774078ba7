"""What friction tests say."""
