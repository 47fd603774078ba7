"""What one asks of a brake: a function for every command, of the same name and quantities.

A quantity is text with its unit (``"94.5 kPa"``) or an SI number; a brake is a catalogue name, the
path of a TOML file, or a BrakeFile. The command line prints what these functions return.
"""
