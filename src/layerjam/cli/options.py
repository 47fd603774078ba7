"""Options that several commands share, and what must hold before anything is computed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layerjam.cli.engine import engine
from layerjam.cli.files import check_figure, check_target

if TYPE_CHECKING:
    from layerjam.measure.options import ReadingOptions

__all__ = ["check_figure", "check_target", "engine"]
BrakeName = Annotated[
    str, typer.Argument(metavar="BRAKE", help="Catalogue name or path of a brake's TOML file.")
]
Files = Annotated[list[Path], typer.Argument(metavar="FILE...", help="Exports of a test machine.")]
Atmosphere = Annotated[
    str | None, typer.Option(metavar="Q", help="Atmosphere of the site, e.g. 95kPa.")
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object in SI units, nothing else.")]
Figure = Annotated[Path | None, typer.Option(metavar="FILE", help="Draw it: .svg, .png or .pdf.")]
Force = Annotated[bool, typer.Option("--force", "--replace", help="Replace files that exist.")]
Replace = Annotated[bool, typer.Option("--replace", help="Replace a figure that exists.")]
Vacuum = Annotated[
    str, typer.Option(metavar="Q", help="Vacuum: atmosphere less the pressure inside, 94.5kPa.")
]
Slip = Annotated[str, typer.Option(metavar="Q", help="Slip of the sheets, e.g. 20mm.")]
FileVacuum = Annotated[
    str | None, typer.Option(metavar="Q", help="Vacuum of files whose sidecar does not say it.")
]
Partial = Annotated[
    bool, typer.Option("--partial", help="Write the brake even if some files were refused.")
]
OutBrake = Annotated[
    Path | None, typer.Option("--out", metavar="FILE.toml", help="Brake file to write.")
]

Negative = Annotated[
    list[str] | None,
    typer.Option(metavar="force|elongation", help="The machine counts this one negative."),
]
Column = Annotated[
    list[str] | None,
    typer.Option(
        metavar="ROLE[:UNIT]=NAME", help="Which column is force, elongation or time, in what unit."
    ),
]
Columns = Annotated[
    str | None,
    typer.Option(
        metavar="ROLE:UNIT,skip,...", help="Every column in order: time:ms,force:N,elongation:mm."
    ),
]
Decimal = Annotated[str | None, typer.Option(metavar=". or ,", help="Decimal sign of the files.")]
Specimen = Annotated[
    int | None, typer.Option(metavar="N", help="Which specimen of files that hold several.")
]
Sheet = Annotated[str | None, typer.Option(metavar="NAME", help="Which sheet of workbooks.")]


def choices(
    negative: list[str] | None,
    column: list[str] | None,
    decimal: str | None,
    columns: str | None = None,
    specimen: int | None = None,
    sheet: str | None = None,
) -> ReadingOptions | None:
    """What the user says of the files where they leave something open."""
    if not (negative or column or decimal or columns or sheet) and specimen is None:
        return None
    from layerjam.measure.options import ReadingOptions

    return ReadingOptions(
        negative=negative or (),
        column=column or (),
        columns=columns,
        decimal=decimal,
        specimen=specimen,
        sheet=sheet,
    )


def hidden_keys(file: str | None, *keys: str) -> tuple[str, ...]:
    """Keys of an answer that are not printed as a line; `file` only where one was written."""
    return keys if file else (*keys, "file")
