"""Basis of all wings: errors, units, files, declared commands, drawing."""
