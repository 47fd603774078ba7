"""The browser app: pages on the declared commands. It computes nothing itself."""
