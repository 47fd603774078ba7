"""Where the defaults of [build] come from, as one phrase each."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

OURS = "ours, no source"
BASIS: Mapping[str, str] = MappingProxyType(
    {
        "cutter": "ours; a service compensates the kerf and wants one part a file",
        "kerf": "nominal lines; measure yours with the coupon",
        "stock_length": "the least rectangle that holds all",
        "stock_width": "the least rectangle that holds all",
        "margin": OURS,
        "gap": OURS,
        "tip_radius": "ours; no sharp corner under the enclosure",
        "clamp_radius": OURS,
        "screws": "",
        "floor": "ours; least printed thickness",
        "wall": "ours; least printed thickness",
        "cheek": OURS,
        "side": OURS,
        "fit": OURS,
        "head_room": OURS,
        "plenum": OURS,
        "back": OURS,
        "air_bore": OURS,
        "neck_length": OURS,
        "neck_stretch": OURS,
        "tie_width": "a common cable tie",
        "tie_slot": OURS,
        "tie_depth": OURS,
        "tie_strength": "ties 2.5 mm wide hold about 8 kg (cableties-online.co.uk)",
        "tie_tension": "a hand's pull, for the seal's check alone",
        "port": "M5 x 0.8, minor diameter 4.134 mm (Yamawa catalogue, p. 799)",
        "pin": "6 mm dowel: Choi 2018, section II-C",
        "pin_clearance": OURS,
        "pin_wall": OURS,
        "edge": OURS,
        "sleeve_clearance": "ours; it is stretched over the cap anyway, and the model weighs none",
        "shrinkage": "data sheets say less than 0.1 %",
        "trim": "ours; cast longer, cut off with sprue and vents",
        "mould_wall": OURS,
        "core_print": OURS,
        "core_clearance": OURS,
        "mould_bolt": "ours; medium clearance hole of M4 (ISO 273)",
        "sprue": OURS,
        "vent": OURS,
        "key": OURS,
        "key_clearance": OURS,
        "waste": "what cup and nozzle keep",
        "print_density": "middle of 1100 to 1200 kg/m^3 for cured SLA resin (renato.design)",
        "print_modulus": "Choi 2018, section II-A, end caps",
        "nut_factor": "dry steel as received (engitoolbox.org)",
        "print_strength": "",
        "laser_bed": "",
        "print_bed": "",
    }
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
