"""Which files a calibration came from, so that nobody validates on them unawares."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam._version import __version__
from layerjam.device.file import BrakeFile, updated_text
from layerjam.errors import Notice

if TYPE_CHECKING:
    from layerjam.identify.calibration.record import Calibration


def sha256(path: str) -> str:
    """Digest of a file, read in pieces."""
    digest = hashlib.sha256()
    with Path(path).open("rb") as handle:
        while block := handle.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def digests(paths: Iterable[str]) -> list[dict[str, str]]:
    """Name and SHA-256 of each file, as a [made_by] table holds them; a made trace has no file."""
    return [{"name": Path(p).name, "sha256": sha256(p)} for p in paths if _there(p)]


def renamed(value: Any, names: Mapping[str, str]) -> Any:
    """A text, or lists and tables of texts, in which files (with their folder) are called anew.

    `names` is {name of a file: what it is called}, for files that lie under other names than those
    their owner knows.
    """
    if isinstance(value, Notice):
        return Notice(renamed(str(value), names), value.key)
    if isinstance(value, str):
        for name, new in names.items():
            if name in value:
                found = rf"(?:[^\s'\"(),;]*/)?{re.escape(name)}"
                value = re.sub(found, new.replace("\\", r"\\"), value)
        return value
    if isinstance(value, Mapping):
        return {renamed(k, names): renamed(v, names) for k, v in value.items()}
    if isinstance(value, list | tuple):
        several = [renamed(v, names) for v in value]
        return several if isinstance(value, list) else tuple(several)
    return value


def calibrated_on(file: BrakeFile, paths: Iterable[str]) -> list[str]:
    """Those of `paths` whose content the brake's [made_by] table names."""
    known = {
        entry.get("sha256")
        for entry in file.notes.get("files", [])
        if isinstance(entry, dict) and isinstance(entry.get("sha256"), str)
    }
    return [path for path in paths if known and _there(path) and sha256(path) in known]


def _there(path: str) -> bool:
    return bool(path) and Path(path).is_file()


def calibrated_text(
    file: BrakeFile,
    found: Calibration,
    depth: str,
    name: str,
    excluded: Sequence[Mapping[str, Any]] = (),
) -> str:
    """The brake's file with what a calibration found, and a [made_by] table on it.

    The table holds program and version, date, depth, the window of the fit, the verdict (the
    sentences of failed checks) and every file's name and SHA-256; of those that were left out by
    hand (`file`, `because`, `sha256`) the reason too.
    """
    failed = [c.sentence for c in found.checks if not c.passed]
    made_by: dict[str, Any] = {
        "program": f"layerjam {__version__} calibrate",
        "date": datetime.now(UTC).date().isoformat(),
        "depth": depth,
        "window": found.window,
        "verdict": "; ".join(failed) if failed else "all checks passed",
        "files": digests(dict.fromkeys(c.path for c in found.curves)),
    }
    if excluded:
        made_by["excluded"] = [
            {"name": Path(one["file"]).name, "because": one["because"]}
            | ({"sha256": one["sha256"]} if one["sha256"] else {})
            for one in excluded
        ]
    return updated_text(file, name, dict(found.sources), made_by)
