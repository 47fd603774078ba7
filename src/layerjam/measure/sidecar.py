"""What a measurement's file does not say itself: NAME.csv.toml beside NAME.csv."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from layerjam.device.load import write_whole
from layerjam.records.reader import Reader
from layerjam.records.toml import parse_toml, read_text
from layerjam.records.values import TextSpec, entries, value
from layerjam.records.writer import plain
from layerjam.simulate.quantities import CROSSHEAD_SPEED, NORMAL_FORCE, SEED, VACUUM
from layerjam.units import FlagSpec, like, quantity

SIDECAR_ENDING = ".toml"
READ = "read"
"""Table of a sidecar that says how to read the file; `measure.options` takes it."""


@dataclass(frozen=True, kw_only=True)
class Facts:
    """The conditions of one test; None (or empty) where nobody stated them."""

    vacuum: float | None = like(VACUUM, "vacuum in the brake during the test", default=None)
    speed: float | None = like(CROSSHEAD_SPEED, default=None)
    repeat: int | None = quantity("1", "number of the repeat", whole=True, default=None)
    brake: str | None = value(TextSpec(text="name of the brake"), default=None)
    normal_force: float | None = like(NORMAL_FORCE, "normal force of a friction test", default=None)
    procedure: str | None = value(TextSpec(text="what was done"), default=None)
    synthetic: bool = value(FlagSpec(text="whether the file is computed"), default=False)
    seed: int | None = like(SEED, "seed of a synthetic file", default=None)
    note: str = value(TextSpec(text="anything else"), default="")


_FIELDS = dict(entries(Facts))


def sidecar_path(path: str | Path) -> Path:
    """Where the facts of a data file stand: the same name with .toml behind it."""
    path = Path(path)
    return path.parent / (path.name + SIDECAR_ENDING)  # a name may be empty: '', '.', '/'


def read_facts(path: str | Path) -> Facts:
    """The facts beside the data file `path`; all unknown where there is no such file.

    Raises FileError, with file and line, for broken TOML, an unknown key or a bad value.
    """
    text = text_beside(path)
    beside = sidecar_path(path)
    reader = Reader(text, beside, _FIELDS, words={})
    reader.take({k: v for k, v in parse_toml(text, beside).items() if k != READ})
    return reader.record(Facts)


def text_beside(path: str | Path) -> str:
    """The text of a data file's sidecar; empty where there is none."""
    beside = sidecar_path(path)
    try:
        there = beside.exists()
    except (OSError, ValueError):  # a name too long or with a NUL is no sidecar either
        there = False
    return read_text(beside) if there else ""


def facts_text(facts: Facts) -> str:
    """The sidecar's TOML; `read_facts` gives back exactly these facts."""
    lines = ["# What the data file beside this one does not say itself."]
    return "\n".join([*lines, *plain(_FIELDS, vars(facts)), ""])


def write_facts(path: str | Path, facts: Facts, force: bool = False) -> Path:
    """Write the sidecar of the data file `path`; FileError where one exists and not `force`."""
    return write_whole(sidecar_path(path), facts_text(facts), force)
