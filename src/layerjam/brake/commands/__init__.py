"""Commands that predict the behaviour of a brake or of a vacuum line."""
