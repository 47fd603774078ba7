"""Which files a calibration came from, so that nobody validates on them unawares."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from datetime import UTC, datetime
from itertools import combinations_with_replacement
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam._version import __version__
from layerjam.device.file import BrakeFile, updated_text
from layerjam.errors import Notice
from layerjam.measure.sidecar import sidecar_path
from layerjam.records.source import Source

if TYPE_CHECKING:
    from layerjam.identify.calibration.record import Calibration
    from layerjam.measure.trace import Trace
    from layerjam.verdict import Acceptance


def sha256(path: str | Path) -> str:
    """Digest of a file, read in pieces."""
    with Path(path).open("rb") as handle:
        return hashlib.file_digest(handle, "sha256").hexdigest()


def digests(paths: Iterable[str], synthetic: Collection[str] = ()) -> list[dict[str, Any]]:
    """Name and SHA-256 of each file, as a [made_by] table holds them; a made trace has no file.

    Of a sidecar the digest too, and of those among `synthetic` that they are.
    """
    made = []
    for path in filter(_there, paths):
        one: dict[str, Any] = {"name": Path(path).name, "sha256": sha256(path)}
        if _there(beside := str(sidecar_path(path))):
            one["facts_sha256"] = sha256(beside)
        if path in synthetic:
            one["synthetic"] = True
        made.append(one)
    return made


def made_from(file: BrakeFile, traces: Iterable[Trace]) -> dict[str, Any]:
    """What a result was computed from: the brake and every file, by name and SHA-256."""
    known = {t.path: t.synthetic for t in traces}
    marked = [path for path, synthetic in known.items() if synthetic]
    brake = {"name": file.name, "sha256": file.sha256}
    return {"brake": brake, "files": digests(known, marked)}


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
    files: Sequence[Mapping[str, Any]] | None = None,
    accepted: Sequence[Acceptance] = (),
    date: str | None = None,
) -> str:
    """The brake's file with what a calibration found, and a [made_by] table on it.

    The table holds program and version, date, depth, the window of the fit, the verdict (the
    sentences of failed checks), the covariance of what was fitted (SI), and every file's name and
    SHA-256; of those that were left out by hand (`file`, `because`, `sha256`) the reason too.
    `files` are the entries of those that were used, where the caller has them. Where a program
    wrote any of them, the source of every number that was fitted says so. `accepted` are the failed
    checks that somebody accepted; `date` (ISO) is today unless given.
    """
    used = {c.path: c.synthetic for c in found.curves}
    failed = [c.sentence for c in found.checks if not c.passed]
    made_by: dict[str, Any] = {
        "program": f"layerjam {__version__} calibrate",
        "date": date or datetime.now(UTC).date().isoformat(),
        "depth": depth,
        "window": found.window,
        "verdict": "; ".join(failed) if failed else "all checks passed",
        "files": files or digests(used, [p for p, synthetic in used.items() if synthetic]),
    }
    if found.covariance:
        pairs = combinations_with_replacement(found.covariance, 2)
        made_by["covariance"] = [
            {"of": a, "and": b, "value": found.covariance[a][b]} for a, b in pairs
        ]
    if excluded:
        made_by["excluded"] = [
            {"name": Path(one["file"]).name, "because": one["because"]}
            | ({"sha256": one["sha256"]} if one["sha256"] else {})
            for one in excluded
        ]
    synthetic = any(curve.synthetic for curve in found.curves)
    return updated_text(file, name, marked(found.sources, synthetic), made_by, accepted)


def marked(
    changes: Mapping[str, tuple[float, Source] | None], synthetic: bool
) -> dict[str, tuple[float, Source] | None]:
    """Numbers for a brake's file; where `synthetic` the source of each that was found says so.

    The numbers carry the mark themselves, since [made_by] is another one after the next command.
    """
    if not synthetic:
        return dict(changes)
    return {path: one and (one[0], one[1].from_synthetic()) for path, one in changes.items()}
