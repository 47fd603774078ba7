"""Design of brakes and arrays, and comparison with published devices."""
