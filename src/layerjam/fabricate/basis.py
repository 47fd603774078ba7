"""Where the defaults of [build] come from, as one phrase each."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from types import MappingProxyType

BASIS: Mapping[str, str] = MappingProxyType(
    tomllib.loads(files("layerjam.fabricate").joinpath("basis.toml").read_text(encoding="utf-8"))
)
"""{key of [build]: what its default rests on}."""

SCREWS = "ours, one for every 20 mm of width; the paper says 'corresponding screw'"
"""What the number of screws rests on where nobody stated it."""

DRAWN = (
    "the paper prints no dimension of cap, clamp, neck, enclosure's end or mould: all are ours",
    "spacers of the same film lie between the sheets in both caps; the paper mentions none",
    "screws and nuts by ISO 4762, 4032, 273 and 888, of steel, 7850 kg/m^3, a screw's thread and "
    "socket taken as a tenth of it",
    "friction of film on printed plastic is not known: film on film stands in for it",
)
"""What else is assumed in every build."""
