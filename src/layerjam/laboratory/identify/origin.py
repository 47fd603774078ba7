"""Origin of a brake's values as one word, derived from its file."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.toml_files.plugin_tables import known_entries
from layerjam.core.units import quantities

ORIGINS: Mapping[str, str] = MappingProxyType(
    {
        "synthetic": "from files written by a program, not measured",
        "edited": "numbers were set by hand",
        "calibrated": "fitted to pulls of this brake",
        "measured": "measured on this brake or this pair of surfaces",
        "paper": "printed in a paper, or derived from a printed value",
        "data sheet": "from the maker's data sheet of the material",
        "handbook": "published for this material, not measured on these surfaces",
        "assumed": "assumed, no source",
        "unstated": "not stated in the file",
    }
)
"""{word: meaning}; the first applicable word is used."""
DECISIVE = MappingProxyType(
    {
        "film.kinetic": "friction",
        "scale_factor": "calibration factor",
        "stiffness_measured": "stiffness",
    }
)
"""Values that determine the force of a pull, with their names in a sentence."""


@dataclass(frozen=True)
class Origin:
    """`word` is one of ORIGINS; `sentence` states its meaning and its sources."""

    word: str
    sentence: str


def describe_origin(file: BrakeFile) -> Origin:
    """Return the origin of a brake's values, from the kinds of sources and the [made_by] table."""
    kinds = {
        name: "paper" if file.sources[path].kind == "inferred" else file.sources[path].kind
        for path, name in DECISIVE.items()
        if path in file.sources
    }
    numbers = (*(path for path, _, _ in quantities(Brake)), *known_entries(file.brake))
    by_hand = [path for path in numbers if (path in file.sources and bool(file.sources[path].was))]
    flags = {
        "synthetic": bool(file.synthetic) or _has_synthetic_file(file),
        "edited": bool(by_hand),
    }
    word = next((word for word in ORIGINS if flags.get(word) or word in kinds.values()), "unstated")
    details = [f"{name}: {kind}" for name, kind in kinds.items()]
    if file.synthetic:
        details.insert(0, f"synthetic: {', '.join(file.synthetic)}")
    if by_hand:
        names = ", ".join(by_hand[:4]) + (", ..." if len(by_hand) > 4 else "")
        details.insert(0, f"by hand: {names}")
    return Origin(word, f"{ORIGINS[word]} ({'; '.join(details)})" if details else ORIGINS[word])


def _has_synthetic_file(file: BrakeFile) -> bool:
    """Return whether a program generated one of the files on which the brake is based."""
    files = file.notes.get("files", [])
    entries = (
        [entry for entry in files if isinstance(entry, dict)] if isinstance(files, list) else []
    )
    return any(entry.get("synthetic") is True for entry in entries)
