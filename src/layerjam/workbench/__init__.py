"""The browser app: pages on the verbs. It computes nothing itself."""
