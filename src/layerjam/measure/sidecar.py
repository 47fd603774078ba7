"""What a measurement's file does not say itself: NAME.csv.toml beside NAME.csv."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any

from layerjam.device.load import write_whole
from layerjam.device.toml import line_of, parse_toml, read_text
from layerjam.errors import FileError, LayerjamError, UnknownNameError
from layerjam.units import exact_text, quantity

SIDECAR_ENDING = ".toml"
READ = "read"
"""Table of a sidecar that says how to read the file; readers.answers takes it."""


@dataclass(frozen=True, kw_only=True)
class Facts:
    """The conditions of one test; None (or empty) where nobody stated them."""

    vacuum: float | None = quantity(
        "Pa", "vacuum in the brake during the test", hi=110e3, symbol="P", default=None
    )
    speed: float | None = quantity("m/s", "speed of the crosshead", open_lo=True, default=None)
    repeat: int | None = quantity("1", "number of the repeat", whole=True, default=None)
    brake: str | None = None
    normal_force: float | None = quantity(
        "N", "normal force of a friction test", open_lo=True, default=None
    )
    procedure: str | None = None
    synthetic: bool = False
    seed: int | None = quantity("1", "seed of a synthetic file", whole=True, default=None)
    note: str = ""


def sidecar_path(path: str | Path) -> Path:
    """Where the facts of a data file stand: the same name with .toml behind it."""
    path = Path(path)
    return path.with_name(path.name + SIDECAR_ENDING)


def read_facts(path: str | Path) -> Facts:
    """The facts beside the data file `path`; all unknown where there is no such file.

    Raises FileError, with file and line, for broken TOML, an unknown key or a bad value.
    """
    beside = sidecar_path(path)
    try:
        if not beside.exists():
            return Facts()
    except (OSError, ValueError):  # a name too long or with a NUL is no sidecar either
        return Facts()
    text = read_text(beside)
    known = {f.name: f for f in fields(Facts)}
    values: dict[str, Any] = {}
    for key, value in parse_toml(text, beside).items():
        if key == READ:
            continue
        try:
            if key not in known:
                raise UnknownNameError("key", key, known)
            values[key] = _value(known[key], key, value)
        except LayerjamError as err:
            raise FileError(beside, str(err), line_of(text, key)) from None
    return Facts(**values)


def _value(place: Any, key: str, value: object) -> object:
    spec = place.metadata.get("quantity")
    if spec is not None and spec.whole:
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**63:
            raise LayerjamError(f"{key} must be a whole number, zero or more: {spec.text}")
        return value
    if spec is not None:
        return spec.read(value, key)
    kind = bool if key == "synthetic" else str
    if not isinstance(value, kind):
        due = "true or false" if kind is bool else "a text in quotes"
        raise LayerjamError(f"{key} must be {due}")
    return value


def facts_text(facts: Facts) -> str:
    """The sidecar's TOML; `read_facts` gives back exactly these facts."""
    import tomlkit

    document = tomlkit.document()
    document.add(tomlkit.comment("What the data file beside this one does not say itself."))
    for place in fields(Facts):
        value = getattr(facts, place.name)
        if value == (None if place.default is MISSING else place.default):
            continue
        spec = place.metadata.get("quantity")
        if spec is not None and not spec.whole:
            value = exact_text(float(value), spec.unit)
        document.add(place.name, value)
    return tomlkit.dumps(document)


def write_facts(path: str | Path, facts: Facts, force: bool = False) -> Path:
    """Write the sidecar of the data file `path`; FileError where one exists and not `force`."""
    text = facts_text(facts)
    return write_whole(sidecar_path(path), lambda place: _write(place, text), force)


def _write(place: Path, text: str) -> None:
    place.write_text(text, encoding="utf-8", newline="\n")
