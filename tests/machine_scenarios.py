"""Scenarios of the machines as they come, and with some values changed."""

from __future__ import annotations

import re
from pathlib import Path

from layerjam.studies.machines import seat_belt
from layerjam.studies.machines.registry import MACHINES
from layerjam.studies.machines.scenario import read_scenario
from layerjam.studies.machines.verdict import Machine


def text_of(name: str) -> str:
    place = Path(seat_belt.__file__).parent / "scenarios" / f"{name}.toml"
    return place.read_text(encoding="utf-8")


def changed(name: str, folder: Path | None = None, **entries: str) -> Machine:
    """A shipped scenario with some values changed, as `table__key="value"`."""
    text = text_of(name)
    for path, value in entries.items():
        table, _, key = path.rpartition("__")
        start = text.index(f"[{table}]") if table else 0
        new, count = re.subn(
            rf"^({key} = \{{ value = )(\"[^\"]*\"|[\d.]+)", rf"\g<1>{value}", text[start:],
            count=1, flags=re.MULTILINE,
        )  # fmt: skip
        assert count == 1, path
        text = text[:start] + new
    return read_scenario(text, name, MACHINES, folder)
