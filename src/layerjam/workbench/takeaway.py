"""What a page gives away as a file: made by the functions that write the command line's files."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.report.style import save
from layerjam.simulate.record import Record
from layerjam.workbench.widgets import button

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENDINGS = ("svg", "png", "pdf")


def buttons(page: str, act: Callable[[str], Any]) -> None:
    """A button for each ending of a figure."""
    for ending in ENDINGS:
        button(f"figure as {ending.upper()}", partial(act, ending), f"{page}-figure-{ending}")


def figure_bytes(figure: Figure, ending: str) -> bytes:
    """The bytes that `--figure FILE.ending` writes."""
    with tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
        return save(figure, Path(folder) / f"figure.{ending}").read_bytes()


def record_bytes(record: Record, ending: str = "csv") -> bytes:
    """The bytes that `--out FILE.ending` writes."""
    with tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
        path = Path(folder) / f"record.{ending}"
        record.save(path)
        return path.read_bytes()
