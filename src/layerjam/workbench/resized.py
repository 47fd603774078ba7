"""A brake with another number of sheets, named after it."""

from __future__ import annotations

import re

from layerjam.commands.edit import edit
from layerjam.device.file import BrakeFile
from layerjam.workbench.desk import Desk


def resized(file: BrakeFile, count: int) -> BrakeFile:
    """The same brake with another number of sheets. Raises LayerjamError."""
    name = f"{re.sub('-[0-9]+-sheets$', '', file.name)}-{count}-sheets"
    made = edit(file, {"sheets.count": float(count)}, name=name, source="set on the page")
    return BrakeFile.read(made.text, name)


def with_sheets(desk: Desk, count: int) -> None:
    """The brake on the desk with another number of sheets. Raises LayerjamError."""
    desk.put_brake(resized(desk.brake, count).text)
