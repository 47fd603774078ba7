"""Force laws of the brake as pure array functions in SI units (docs/nomenclature.md)."""
