"""Real hardware and its virtual twin: firmware, line, gateway, driver."""
