"""The command line; its names, options and JSON keys are a contract (docs/commands.md)."""
