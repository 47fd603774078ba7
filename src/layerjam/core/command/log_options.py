"""Options for reading an ambiguous pressure log, shared by the wings that read one."""

from typing import Annotated

from layerjam.core.command.declare import Help, options

Decimal = Annotated[str | None, Help("Decimal separator of the files.", metavar=". or ,")]


@options
class LogOptions:
    """Options for reading an ambiguous pressure log."""

    columns: Annotated[
        str | None,
        Help(
            "Content of the columns, in order (time:ms,skip,pressure:kPa) or by name "
            "(pressure:kPa=Chamber).",
            metavar="ROLE:UNIT,...",
        ),
    ] = None
    decimal: Decimal = None
    reading: Annotated[
        str | None,
        Help("Pressure reference.", metavar="absolute|gauge|vacuum"),
    ] = None
