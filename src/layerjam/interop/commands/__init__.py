"""Commands that export a brake."""
