"""The enclosure's silicone from a tensile test."""
