"""What a dropped file is, from its content: where it belongs, and what reads it if no page does."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType

from layerjam.device.file import BrakeFile
from layerjam.errors import LayerjamError
from layerjam.fluid.file import LineFile
from layerjam.measure.log import ACCELERATION, PRESSURE, TIME, read_log
from layerjam.measure.runs import ENDING
from layerjam.measure.sidecar import READ, Facts
from layerjam.records.toml import parse_toml

SPECIFICATION = frozenset({"vary", "objectives", "constraints", "weights", "stop"})
"""Keys that only a design's specification has."""


@dataclass(frozen=True)
class Elsewhere:
    """What reads a file that no page takes: what it is, and the command, with FILE for its name."""

    what: str
    command: str

    def sentence(self, name: str) -> str:
        """Where it is read."""
        shown = f"'{name}'" if " " in name else name
        return f"{self.what}. The command reads it: {self.command.replace('FILE', shown)}"


ELSEWHERE = MappingProxyType(
    {
        "silicone": Elsewhere(
            "A tensile curve of the enclosure's silicone", "layerjam enclosure FILE"
        ),
        "pressure": Elsewhere(
            "A log of pressure over time", "layerjam leak FILE, or layerjam pump-down FILE"
        ),
        "acceleration": Elsewhere("A log of an acceleration", "layerjam crash FILE"),
        "run": Elsewhere(
            "A run of the bench without force and elongation",
            "layerjam bench export FILE",
        ),
    }
)
"""{kind: what reads it}."""


def toml_kind(text: str) -> str:
    """What a TOML text is by its keys: "brake", "line", "specification", "sidecar" or "" (none)."""
    try:
        keys = set(parse_toml(text, "the file"))
    except LayerjamError:
        return ""
    known = {
        "brake": _tops(BrakeFile.fields),
        "line": _tops(LineFile.fields),
        "specification": SPECIFICATION,
        "sidecar": {READ, *(f.name for f in fields(Facts))},
    }
    scores = {kind: len(keys & of) for kind, of in known.items()}
    best = max(scores, key=lambda kind: scores[kind])
    return best if scores[best] else ""


def _tops(paths: Mapping[str, object]) -> set[str]:
    """The tables and keys at the top of a file; what every file has tells nothing."""
    return {path.partition(".")[0] for path in paths} - {"name", "title", "site", "gas"}


def elsewhere_of(path: Path) -> str:
    """The kind of ELSEWHERE that a file is which is no test of force over elongation; else ""."""
    from layerjam.identify.rubber.tensile import read_rubber

    if path.suffix == ENDING:
        return "run"
    try:
        read_rubber(path)
    except LayerjamError:
        pass
    else:
        return "silicone"
    for kind, want in (("pressure", PRESSURE), ("acceleration", ACCELERATION)):
        try:
            read_log(path, [TIME, want])
        except LayerjamError:
            continue
        return kind
    return ""
