"""One word for where a brake's numbers come from, out of the facts in its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.units import quantities

ORIGINS: Mapping[str, str] = MappingProxyType(
    {
        "synthetic": "found in files that a program wrote, not measured",
        "edited": "numbers were set by hand",
        "calibrated": "fitted to pulls of this brake",
        "measured": "measured on this brake or this pair of surfaces",
        "paper": "printed in a paper, or following from what is printed",
        "data sheet": "from the maker's data sheet of the material",
        "handbook": "published for such a material, not measured on these surfaces",
        "assumed": "assumed, no source",
        "unstated": "the file does not say",
    }
)
"""{word: what it says of the brake}, the first that applies."""
DECISIVE = MappingProxyType(
    {
        "film.kinetic": "friction",
        "scale_factor": "calibration factor",
        "stiffness_measured": "stiffness",
    }
)
"""The numbers that set the force of a pull, and how a sentence calls them."""


@dataclass(frozen=True)
class Origin:
    """`word` is one of ORIGINS; `sentence` says what it means and what it rests on."""

    word: str
    sentence: str


def origin(file: BrakeFile) -> Origin:
    """Where a brake's numbers come from: from kinds of sources and the [made_by] table alone."""
    kinds = {
        name: "paper" if file.sources[path].kind == "inferred" else file.sources[path].kind
        for path, name in DECISIVE.items()
        if path in file.sources
    }
    by_hand = [path for path, _, _ in quantities(Brake) if _was(file, path)]
    known = {"synthetic": bool(file.synthetic) or _synthetic(file), "edited": bool(by_hand)}
    word = next((word for word in ORIGINS if known.get(word) or word in kinds.values()), "unstated")
    details = [f"{name}: {kind}" for name, kind in kinds.items()]
    if file.synthetic:
        details.insert(0, f"synthetic: {', '.join(file.synthetic)}")
    if by_hand:
        some = ", ".join(by_hand[:4]) + (", ..." if len(by_hand) > 4 else "")
        details.insert(0, f"by hand: {some}")
    return Origin(word, f"{ORIGINS[word]} ({'; '.join(details)})" if details else ORIGINS[word])


def _was(file: BrakeFile, path: str) -> bool:
    return path in file.sources and bool(file.sources[path].was)


def _synthetic(file: BrakeFile) -> bool:
    """Whether one of the files that it was made from is marked as made by a program."""
    files = file.notes.get("files", [])
    entries = [one for one in files if isinstance(one, dict)] if isinstance(files, list) else []
    return any(one.get("synthetic") is True for one in entries)
