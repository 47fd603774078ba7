"""Files of records: TOML read with units, sources and line numbers, changed and written."""
