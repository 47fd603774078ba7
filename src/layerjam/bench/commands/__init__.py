"""Commands that plan, control and run a bench."""
