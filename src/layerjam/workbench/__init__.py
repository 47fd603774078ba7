"""Browser app whose pages call the declared commands; it computes nothing itself."""
