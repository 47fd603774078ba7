"""Which files a calibration came from, so that nobody validates on them unawares."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

from layerjam.device.file import BrakeFile


def sha256(path: str) -> str:
    """Digest of a file, read in pieces."""
    digest = hashlib.sha256()
    with Path(path).open("rb") as handle:
        while block := handle.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def calibrated_on(file: BrakeFile, paths: Iterable[str]) -> list[str]:
    """Those of `paths` whose content the brake's [made_by] table names."""
    known = {
        entry.get("sha256")
        for entry in file.notes.get("files", [])
        if isinstance(entry, dict) and isinstance(entry.get("sha256"), str)
    }
    return [path for path in paths if known and sha256(path) in known]
