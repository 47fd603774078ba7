"""A vacuum line as an argument of a command, and its fluid."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from layerjam.brake.commands.arguments import load_record_file
from layerjam.brake.fluid.line import Line
from layerjam.brake.fluid.line_file import LineFile, load_line
from layerjam.core.command.declare import Help, Input
from layerjam.core.errors import Notice

AnyLine = str | Path | LineFile | Line
Fluid = Annotated[Literal["air", "water"], Help("Fluid in the line.")]
ONLY_COMPLIANCE = Notice(
    "water: pump and compliance only; neither tube nor bubbles are modelled", "water-simplified"
)


def load_line_file(line: AnyLine, atmosphere: float | str | None = None) -> LineFile:
    """Return the line with its name and sources, at the given atmosphere, if any.

    A record created in Python is checked like a file. Raises UnknownNameError, FileError or
    QuantityError.
    """
    return load_record_file(line, LineFile, load_line, atmosphere)


def convert_line(value: AnyLine, arguments: Mapping[str, Any]) -> LineFile:
    """Return the line of an argument, at the atmosphere in a second argument."""
    return load_line_file(value, arguments.get("atmosphere"))


LineInput = Annotated[
    LineFile,
    Input("Catalogue name or path of a line's TOML file.", metavar="LINE", convert=convert_line),
]
