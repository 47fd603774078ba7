"""Files in a campaign's folder, and the use of each."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import catalogue, load
from layerjam.core.errors import FileError, LayerjamError
from layerjam.laboratory.dataset import checksums
from layerjam.laboratory.identify.provenance import find_calibration_files
from layerjam.laboratory.measure.conditions import LIST, read_conditions
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.read import open_traces
from layerjam.laboratory.measure.sidecar import FOLDER, Facts, sidecar_path

LIMIT = 5_000
"""Largest number of files in a campaign."""
FITTED = "depth"
"""Key of a note that a calibration writes to the brake file."""


@dataclass(frozen=True)
class Campaign:
    """Files in a folder, by name: measurements by use, and brakes."""

    folder: Path
    friction: tuple[str, ...]
    pulls: tuple[str, ...]
    brakes: tuple[str, ...]
    facts: tuple[Facts, ...]
    """Metadata of the measurements."""

    @property
    def measurements(self) -> tuple[str, ...]:
        """Friction tests and pulls."""
        return (*self.friction, *self.pulls)


def map_campaign(folder: Path) -> dict[str, Path]:
    """Return {name: path} of the files in a folder, without hidden files and links.

    Raises FileError if there is no such folder.
    """
    if not folder.is_dir():
        raise FileError(folder, "is not a folder; choose the folder of the measurements")
    files = {
        name: path
        for name, path in checksums.map_files(folder).items()
        if not path.is_symlink() and not any(part[0] == "." for part in name.split("/"))
    }
    if len(files) > LIMIT:
        raise FileError(folder, f"contains {len(files)} files; at most {LIMIT} can be published")
    return files


def read_campaign(root: Path, options: ReadingOptions) -> Campaign:
    """Return the files in a folder: tests with a normal force are friction tests, others are pulls.

    A file is a measurement if it has a sidecar or a reader can open it. Raises FileError if there
    is no such folder, or no measurement in it.
    """
    names = map_campaign(root)
    friction: list[str] = []
    pulls: list[str] = []
    facts: list[Facts] = []
    for name in names:
        if not _is_measurement(root / name, options):
            continue
        entry = _read_facts(root / name, options)
        facts.append(entry)
        (friction if entry.normal_force else pulls).append(name)
    if not facts:
        raise FileError(root, "contains no readable measurement")
    brakes = [n for n in names if n.endswith(".toml") and _read_brake(root / n) is not None]
    return Campaign(root, tuple(friction), tuple(pulls), tuple(brakes), tuple(facts))


def find_brake(tests: Campaign) -> str:
    """Return the tested brake: a path inside the folder, or a name in the catalogue.

    It is the folder's only uncalibrated brake, or else the one that all sidecars name.
    Raises FileError if neither determines the brake.
    """
    candidates = [n for n in tests.brakes if FITTED not in load(tests.folder / n).notes]
    if len(candidates) == 1:
        return candidates[0]
    names = {facts.brake for facts in tests.facts}
    name = str(next(iter(names))) if len(names) == 1 else ""
    if name in catalogue():
        return name
    matches = [n for n in candidates if load(tests.folder / n).name == name]
    if len(matches) == 1:
        return matches[0]
    brakes = ", ".join(candidates[:4]) if candidates else "no brake file"
    raise FileError(tests.folder, f"contains {brakes}; specify the tested brake (--brake)")


def split_calibration_pulls(tests: Campaign) -> tuple[list[str], list[str]]:
    """Return the pulls to which a calibrated brake in the folder was fitted, and the others.

    The first list is empty if there is no such brake, or if it was fitted to all or none of the
    pulls.
    """
    for name in tests.brakes:
        file = load(tests.folder / name)
        if FITTED in file.notes:
            paths = set(find_calibration_files(file, [str(tests.folder / p) for p in tests.pulls]))
            pulls = [p for p in tests.pulls if str(tests.folder / p) in paths]
            if 0 < len(pulls) < len(tests.pulls):
                return pulls, [p for p in tests.pulls if p not in pulls]
    return [], list(tests.pulls)


def _is_measurement(path: Path, options: ReadingOptions) -> bool:
    if path.name in (LIST, FOLDER) or path.suffix == ".toml":
        return False
    if sidecar_path(path).is_file():
        return True
    try:
        return bool(open_traces(path, options))
    except LayerjamError:
        return False


def _read_facts(path: Path, options: ReadingOptions) -> Facts:
    """Return the metadata, empty if unreadable: the stage that uses the file reports that."""
    try:
        return read_conditions(path, options)
    except LayerjamError:
        return Facts()


def _read_brake(path: Path) -> BrakeFile | None:
    try:
        return load(path)
    except LayerjamError:
        return None


def relative_paths(folder: Path, files: Sequence[str | Path]) -> Iterator[str]:
    """Yield the names of files in the folder; raises FileError for a file outside."""
    for file in files:
        path = Path(file)
        location = path if path.exists() else folder / path
        if not location.is_file():
            raise FileError(file, "does not exist")
        if not location.resolve().is_relative_to(folder.resolve()):
            raise FileError(file, f"is not in {folder}; a dataset contains the files of one folder")
        relative_path = location.resolve().relative_to(folder.resolve())
        yield checksums.compose_name(relative_path.as_posix())
