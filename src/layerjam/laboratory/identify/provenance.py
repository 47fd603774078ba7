"""Record of the files of a calibration, to prevent validation with the same files by mistake."""

import hashlib
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam._version import __version__
from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.core.errors import Notice
from layerjam.core.toml_files.source import Source
from layerjam.laboratory.measure.sidecar import sidecar_path

if TYPE_CHECKING:
    from layerjam.core.verdict import Verdict
    from layerjam.laboratory.identify.calibration.result import Calibration
    from layerjam.laboratory.measure.trace import Trace


def sha256(path: str | Path) -> str:
    """Return the SHA-256 digest of a file, read in chunks."""
    with Path(path).open("rb") as handle:
        return hashlib.file_digest(handle, "sha256").hexdigest()


def digest_files(paths: Iterable[str], synthetic: Collection[str] = ()) -> list[dict[str, Any]]:
    """Return name and SHA-256 of each file for a [made_by] table; simulated traces have none.

    An entry includes the digest of the sidecar, and a flag if the file is among `synthetic`.
    """
    entries = []
    for path in filter(_is_file, paths):
        entry: dict[str, Any] = {"name": Path(path).name, "sha256": sha256(path)}
        if _is_file(sidecar := str(sidecar_path(path))):
            entry["facts_sha256"] = sha256(sidecar)
        if path in synthetic:
            entry["synthetic"] = True
        entries.append(entry)
    return entries


def list_inputs(file: BrakeFile, traces: "Iterable[Trace]") -> dict[str, Any]:
    """Return the inputs of a result: the brake and every file, each with name and SHA-256."""
    synthetic_files = {t.path: t.synthetic for t in traces}
    synthetic_paths = [path for path, synthetic in synthetic_files.items() if synthetic]
    brake = {"name": file.name, "sha256": file.sha256}
    return {"brake": brake, "files": digest_files(synthetic_files, synthetic_paths)}


def rename_files(value: Any, names: Mapping[str, str]) -> Any:
    """Return a text, or lists and tables of texts, with files renamed and their folder removed.

    `names` is {name of a file: new name}, for files that are stored under names other than the
    user's own.
    """
    if isinstance(value, Notice):
        return Notice(rename_files(str(value), names), value.key)
    if isinstance(value, str):
        for name, new in names.items():
            if name in value:
                pattern = rf"(?:[^\s'\"(),;]*[/\\])?{re.escape(name)}"
                value = re.sub(pattern, new.replace("\\", r"\\"), value)
        return value
    if isinstance(value, Mapping):
        return {rename_files(k, names): rename_files(v, names) for k, v in value.items()}
    if isinstance(value, list | tuple):
        several = [rename_files(v, names) for v in value]
        return several if isinstance(value, list) else tuple(several)
    return value


def find_calibration_files(file: BrakeFile, paths: Iterable[str]) -> list[str]:
    """Return those of `paths` whose content is listed in the brake's [made_by] table."""
    calibration_digests = {
        entry.get("sha256")
        for entry in file.notes.get("files", [])
        if isinstance(entry, dict) and isinstance(entry.get("sha256"), str)
    }
    return [
        path
        for path in paths
        if calibration_digests and _is_file(path) and sha256(path) in calibration_digests
    ]


def _is_file(path: str) -> bool:
    return bool(path) and Path(path).is_file()


def format_brake(
    file: BrakeFile,
    calibration: "Calibration",
    depth: str,
    name: str,
    exclusions: Sequence[Mapping[str, Any]] = (),
    files: Sequence[Mapping[str, Any]] | None = None,
    verdict: "Verdict | None" = None,
    date: str | None = None,
    brake_sha256: str = "",
) -> str:
    """Return the text of the brake file with a calibration and its [made_by] table.

    [made_by] contains the program, version, date, depth, window, verdict (sentences of failed
    checks), and every file's name and SHA-256; [[tested]] contains covariance, scatter and tested
    range. `exclusions` lists the files left out, with the reason (`file`, `because`, `sha256`,
    `automatic`); `files` are the entries of the files used, if the caller has them. If a program
    generated any of them, the source of every fitted value records this. `verdict` is that of the
    calibration, with the failed checks that a person accepted; `date` (ISO) defaults to today.
    `brake_sha256` is the digest of the brake's file, if `file` was derived from it in the same run
    and was not stored.
    """
    from layerjam.laboratory.identify.calibration.evidence import make_calibration_evidence

    used = {c.path: c.synthetic for c in calibration.curves}
    failures = [c.sentence for c in calibration.checks if not c.passed]
    made_by: dict[str, Any] = {
        "program": f"layerjam {__version__} calibrate",
        "date": date or datetime.now(UTC).date().isoformat(),
        "depth": depth,
        "window": calibration.window,
        "verdict": "; ".join(failures) if failures else "all checks passed",
        "files": files or digest_files(used, [p for p, synthetic in used.items() if synthetic]),
    }
    if brake_sha256:
        made_by["brake_sha256"] = brake_sha256
    if exclusions:
        made_by["excluded"] = [
            {"name": Path(entry["file"]).name, "because": entry["because"]}
            | ({"sha256": entry["sha256"]} if entry["sha256"] else {})
            | ({"automatic": True} if entry.get("automatic") else {})
            for entry in exclusions
        ]
    synthetic = any(curve.synthetic for curve in calibration.curves)
    changes = mark_sources(calibration.sources, synthetic)
    evidence = make_calibration_evidence(file, calibration, changes, made_by["date"])
    return updated_text(file, name, changes, made_by, verdict, evidence)


def mark_sources(
    changes: Mapping[str, tuple[float, Source] | None], synthetic: bool
) -> dict[str, tuple[float, Source] | None]:
    """Return values for a brake file, with their sources marked if `synthetic`.

    The mark belongs to the values, because the next command replaces [made_by].
    """
    if not synthetic:
        return dict(changes)
    return {
        path: change and (change[0], change[1].to_synthetic()) for path, change in changes.items()
    }
