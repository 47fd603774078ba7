"""Files of records: TOML with units, sources and line numbers; read, changed and written."""
