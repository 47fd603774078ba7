"""The sleeve's silicone from a tensile test."""
