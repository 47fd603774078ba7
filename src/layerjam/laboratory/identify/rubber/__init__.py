"""Analysis of tensile tests of the enclosure's silicone."""
