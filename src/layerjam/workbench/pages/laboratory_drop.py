"""Practice files, made here by the virtual laboratory."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from layerjam.measure.sidecar import SIDECAR_ENDING
from layerjam.workbench.call import Call, Subject


def practice_files(folder: Path, tell: Callable[[str, float], None]) -> dict[str, bytes]:
    """Files of the built-in campaign of the virtual laboratory with their sidecars, by name."""
    place = folder / "practice"
    shutil.rmtree(place, ignore_errors=True)
    try:
        made = Call("lab", (Subject("practice"),)).run(out=place, progress=tell)
        found = {}
        for path in map(Path, made.files):
            for one in (path, path.with_name(path.name + SIDECAR_ENDING)):
                if one.exists():
                    found[one.name] = one.read_bytes()
        return found
    finally:
        shutil.rmtree(place, ignore_errors=True)
