"""Arguments and options that the commands on a vacuum line share."""

from __future__ import annotations

from typing import Annotated

import typer

Line = Annotated[
    str, typer.Argument(metavar="LINE", help="Catalogue name or path of a line's TOML file.")
]
Safe = Annotated[
    str,
    typer.Option(metavar="release|hold", help="Where a fault ends: vented, or valves closed."),
]
Kind = Annotated[str, typer.Option(metavar="bang-bang|pi|scheduled", help="The control law.")]
Fluid = Annotated[str, typer.Option(metavar="air|water", help="What fills the line.")]
Sample = Annotated[str | None, typer.Option(metavar="Q", help="Time between samples; 10 ms.")]
Range = Annotated[
    str | None, typer.Option(metavar="Q", help="Greatest vacuum the sensor shows, 103kPa.")
]
Noise = Annotated[
    str | None, typer.Option(metavar="Q", help="Standard deviation of a reading, 50Pa.")
]
Reversible = Annotated[
    bool, typer.Option("--reversible", help="The pump regulates downwards by running backwards.")
]
LeastRun = Annotated[
    str | None, typer.Option(metavar="Q", help="Shortest run and rest of the pump, 0.2s.")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the sensor's noise.")]
