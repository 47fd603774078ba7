"""Why it resists: force laws as pure array functions in SI units (docs/nomenclature.md)."""
