"""What the laboratory has computed: a call on files, its result, and what it wrote."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from layerjam.device.file import BrakeFile
from layerjam.workbench.call import Call
from layerjam.workbench.uploads import in_users_toml


@dataclass(frozen=True)
class Done:
    """A call that was computed: its result and picture (SVG), the brake it wrote; or why not."""

    call: Call
    result: Any = None
    text: str = ""
    brake: BrakeFile | None = None
    picture: str = ""
    problem: str = ""
    pages: Mapping[str, bytes] = field(default_factory=dict)
    """Files of a report."""


def stem_of(name: str) -> str:
    """The name that files of this brake begin with: safe in a path, without what steps append."""
    plain = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-")[:60] or "brake"
    return re.sub(r"(-tested|-calibrated)+$", "", plain) or "brake"


def written(call: Call, folder: Path) -> str:
    """The brake that a call wrote, in the user's words; "" where it wrote none."""
    path = folder / call.out
    if not call.out or not path.is_file():
        return ""
    return in_users_toml(path.read_text(encoding="utf-8"), call.names)


def pages_of(folder: Path) -> dict[str, bytes]:
    """The files of a report by name."""
    found = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}
