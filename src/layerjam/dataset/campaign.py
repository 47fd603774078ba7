"""What lies in a campaign's folder, and what each file of it is for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from layerjam.dataset import checksums
from layerjam.device.file import BrakeFile
from layerjam.device.load import catalogue, load
from layerjam.errors import FileError, LayerjamError
from layerjam.identify.provenance import calibrated_on
from layerjam.measure.conditions import LIST, conditions
from layerjam.measure.options import ReadingOptions
from layerjam.measure.readers.read import open_traces
from layerjam.measure.sidecar import FOLDER, Facts, sidecar_path

MOST = 5_000
"""Files of a campaign."""
FITTED = "depth"
"""Note that a calibration leaves in the brake's file."""


@dataclass(frozen=True)
class Campaign:
    """Paths inside the folder: measurements by their use, and every file there is."""

    folder: Path
    files: tuple[str, ...]
    friction: tuple[str, ...]
    pulls: tuple[str, ...]
    brakes: tuple[str, ...]
    facts: tuple[Facts, ...]
    """Of the measurements."""

    @property
    def measurements(self) -> tuple[str, ...]:
        """Friction tests and pulls."""
        return (*self.friction, *self.pulls)


def campaign(folder: str | Path, options: ReadingOptions) -> Campaign:
    """What a folder holds; what states a normal force is a friction test, else a pull.

    A file is a measurement where facts stand beside it or a reader can open it; hidden files and
    links are left out. Raises FileError for what is no folder, or holds no measurement.
    """
    root = Path(folder)
    if not root.is_dir():
        raise FileError(folder, "is no folder; name the one that holds the measurements")
    names = [n for n in checksums.inside(root) if not any(p[0] == "." for p in n.split("/"))]
    if len(names) > MOST:
        raise FileError(folder, f"holds {len(names)} files; at most {MOST} are published at once")
    friction: list[str] = []
    pulls: list[str] = []
    facts: list[Facts] = []
    for name in names:
        if not _measured(root / name, options):
            continue
        known = _facts(root / name, options)
        facts.append(known)
        (friction if known.normal_force else pulls).append(name)
    if not facts:
        raise FileError(folder, "holds no measurement that could be read")
    brakes = [n for n in names if n.endswith(".toml") and _brake(root / n) is not None]
    return Campaign(root, tuple(names), tuple(friction), tuple(pulls), tuple(brakes), tuple(facts))


def brake_of(found: Campaign) -> str:
    """The brake that was measured: a path inside the folder, or a name of the catalogue.

    The folder's only brake that no calibration made, else the one all facts name. Raises FileError
    where neither says.
    """
    plain = [n for n in found.brakes if FITTED not in load(found.folder / n).notes]
    if len(plain) == 1:
        return plain[0]
    named = {facts.brake for facts in found.facts}
    name = str(next(iter(named))) if len(named) == 1 else ""
    if name in catalogue():
        return name
    own = [n for n in plain if load(found.folder / n).name == name]
    if len(own) == 1:
        return own[0]
    which = ", ".join(plain[:4]) if plain else "no brake's file"
    raise FileError(found.folder, f"holds {which}; say which one was tested (--brake)")


def apart(found: Campaign) -> tuple[list[str], list[str]]:
    """The pulls that a calibrated brake of the folder was fitted on, and the others.

    None of the first where there is no such brake, or where it knows all of them or none.
    """
    for name in found.brakes:
        file = load(found.folder / name)
        if FITTED in file.notes:
            known = set(calibrated_on(file, [str(found.folder / p) for p in found.pulls]))
            fitted = [p for p in found.pulls if str(found.folder / p) in known]
            if 0 < len(fitted) < len(found.pulls):
                return fitted, [p for p in found.pulls if p not in fitted]
    return [], list(found.pulls)


def _measured(path: Path, options: ReadingOptions) -> bool:
    if path.name in (LIST, FOLDER) or path.suffix == ".toml":
        return False
    if sidecar_path(path).is_file():
        return True
    try:
        return bool(open_traces(path, options))
    except LayerjamError:
        return False


def _facts(path: Path, options: ReadingOptions) -> Facts:
    """Unknown where they cannot be read: the stage that uses the file says why."""
    try:
        return conditions(path, options)
    except LayerjamError:
        return Facts()


def _brake(path: Path) -> BrakeFile | None:
    try:
        return load(path)
    except LayerjamError:
        return None


def within(folder: Path, files: Sequence[str | Path]) -> Iterator[str]:
    """Paths inside the folder; FileError for a file outside."""
    for file in files:
        path = Path(file)
        here = path if path.exists() else folder / path
        if not here.is_file():
            raise FileError(file, "is not there")
        if not here.resolve().is_relative_to(folder.resolve()):
            raise FileError(file, f"does not lie in {folder}; a dataset holds one folder's files")
        yield here.resolve().relative_to(folder.resolve()).as_posix()
