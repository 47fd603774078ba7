"""Measured files as arguments of commands: paths or traces, and options for reading them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Protocol, runtime_checkable

from layerjam.brake.simulate.quantities import CROSSHEAD_SPEED, VACUUM
from layerjam.core.command.declare import Help, Input, options
from layerjam.core.command.log_options import Decimal
from layerjam.core.units import get_spec
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Trace


@runtime_checkable
class DataFrame(Protocol):
    """A pandas DataFrame."""

    columns: Any
    index: Any
    attrs: Any


Measured = str | Path | Trace
"""A file of a test machine, or a trace that was read (and perhaps cut) in Python."""
SPECIMEN = get_spec(ReadingOptions, "specimen")
NORMAL_FORCE = replace(get_spec(Facts, "normal_force"), example="2.45N")
AnyFiles = Sequence[Measured | DataFrame] | Measured | DataFrame


def list_files(files: AnyFiles) -> list[Measured]:
    """Return the files as a list; a single path, trace or data frame becomes a list of one."""
    return _read_measurements(files, {})


def _read_measurements(files: AnyFiles, arguments: Mapping[str, Any]) -> list[Measured]:
    """Return paths and traces; data frames are read with the options in `arguments`."""
    options = next(
        (source for source in arguments.values() if isinstance(source, ReadingOptions)), None
    )
    sources = [files] if isinstance(files, str | Path | Trace | DataFrame) else list(files)
    return [
        _read_frame(source, options or ReadingOptions(), number)
        if isinstance(source, DataFrame)
        else source
        for number, source in enumerate(sources, 1)
    ]


def _read_frame(frame: DataFrame, options: ReadingOptions, number: int) -> Trace:
    from layerjam.laboratory.measure.readers.frame import read_frame

    return read_frame(frame, options, number)


Files = Annotated[
    Sequence[Measured],
    Input("Files from a test machine.", metavar="FILE...", convert=_read_measurements),
]
FileVacuum = Annotated[
    float | None, VACUUM, Help("Vacuum of files whose sidecar does not state it.")
]
Partial = Annotated[bool, Help("Write the brake even if some files were rejected.")]
Columns = Annotated[
    str | None,
    Help(
        "Content of the columns, in order (time:ms,skip,force:N) or by name (force:N=Load).",
        metavar="ROLE:UNIT,...",
    ),
]
Negative = Annotated[
    Sequence[str],
    Help("Columns recorded with the opposite sign.", metavar="force|elongation"),
]


@options
class TableOptions(ReadingOptions):
    """Options for reading an ambiguous table or log."""

    columns: Columns = None
    decimal: Decimal = None


@options
class SpecimenOptions(TableOptions):
    """Options for reading ambiguous tensile tests of a material."""

    negative: Negative = ()


@options
class FileOptions(TableOptions):
    """Options for reading ambiguous files of a test machine."""

    negative: Negative = ()
    column: Annotated[
        Sequence[str] | Mapping[str, str],
        Help(
            "Column for a role (force, elongation or time), with its unit.",
            metavar="ROLE[:UNIT]=NAME",
        ),
    ] = ()
    specimen: Annotated[
        int | None, SPECIMEN, Help("Specimen to use from files that contain several.")
    ] = None
    sheet: Annotated[str | None, Help("Worksheet to read from workbooks.", metavar="NAME")] = None
    names: Annotated[
        str | None,
        Help(
            "Pattern for the file names, such as 'pull_{vacuum}_{speed:mm/s}_*'; for two "
            "kinds of files, two patterns separated by |.",
            metavar="PATTERN",
        ),
    ] = None
    speed: Annotated[
        float | None,
        CROSSHEAD_SPEED,
        Help("Speed of the crosshead, if no file states it."),
    ] = None
