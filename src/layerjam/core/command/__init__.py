"""The commands, each declared once as a function with a typed result.

A quantity is text with its unit (``"94.5 kPa"``) or an SI number; a brake is a catalogue name, the
path of a TOML file, a BrakeFile or a Brake. The command line, the page's controls, the tables of
the docs and the JSON Schemas are generated from these declarations.
"""
