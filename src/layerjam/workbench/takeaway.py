"""What a page gives away as a file: made by the functions that write the command line's files."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from layerjam.commands.results import Result
from layerjam.workbench.widgets import button

ENDINGS = ("svg", "png", "pdf")


def buttons(page: str, act: Callable[[str], Any]) -> None:
    """A button for each ending of a figure."""
    for ending in ENDINGS:
        button(f"figure as {ending.upper()}", partial(act, ending), f"{page}-figure-{ending}")


def file_bytes(result: Result, ending: str) -> bytes:
    """The bytes of a result's figure or record, as the command writes them."""
    with tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
        return result.save(Path(folder) / f"file.{ending}").read_bytes()
