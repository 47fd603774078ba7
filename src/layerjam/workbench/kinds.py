"""Recognises dropped files by their content, and names commands for those that no page reads."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line_file import LineFile
from layerjam.core.errors import LayerjamError
from layerjam.core.toml_files.toml import parse_toml
from layerjam.laboratory.measure.log import ACCELERATION, PRESSURE, TIME, read_log
from layerjam.laboratory.measure.runs import ENDING
from layerjam.laboratory.measure.sidecar import READ, Facts

SPECIFICATION = frozenset({"vary", "objectives", "constraints", "weights", "stop"})
"""Keys that only a design specification contains."""


@dataclass(frozen=True)
class OtherReader:
    """Description of a file that no page reads, and the command for it, with FILE as its name."""

    what: str
    command: str

    def sentence(self, name: str) -> str:
        """Return a sentence with the command that reads the file."""
        argument = f"'{name}'" if " " in name else name
        return f"{self.what}. Read it with the command {self.command.replace('FILE', argument)}"


OTHER_READERS = {
    "silicone": OtherReader(
        "A tensile curve of the enclosure's silicone", "layerjam enclosure FILE"
    ),
    "pressure": OtherReader("A pressure log", "layerjam leak FILE, or layerjam pump-down FILE"),
    "acceleration": OtherReader("An acceleration log", "layerjam crash FILE"),
    "run": OtherReader(
        "A bench run without force and elongation",
        "layerjam bench export FILE",
    ),
}
"""{kind of file: description and command}."""


def detect_toml_kind(text: str) -> str:
    """Return the kind of a TOML text: "brake", "line", "specification", "sidecar", or ""."""
    try:
        keys = set(parse_toml(text, "the file"))
    except LayerjamError:
        return ""
    keys_of = {
        "brake": _top_level_keys(BrakeFile.fields),
        "line": _top_level_keys(LineFile.fields),
        "specification": SPECIFICATION,
        "sidecar": {READ, *(f.name for f in fields(Facts))},
    }
    scores = {kind: len(keys & names) for kind, names in keys_of.items()}
    best = max(scores, key=lambda kind: scores[kind])
    return best if scores[best] else ""


def _top_level_keys(paths: Mapping[str, object]) -> set[str]:
    """Return the top-level tables and keys of a file, except those that both kinds share."""
    return {path.partition(".")[0] for path in paths} - {"name", "title", "site", "gas"}


def find_other_reader(path: Path) -> str:
    """Return the kind, in OTHER_READERS, of a file that no page reads; "" if it has none."""
    from layerjam.laboratory.identify.rubber.tensile import read_rubber

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
