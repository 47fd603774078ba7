"""`new`: a commented brake file to edit."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from layerjam.brake.commands.arguments import (
    OutBrake,
    Overwrite,
)
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Result, fact, result
from layerjam.core.evolve import evolve
from layerjam.core.store import store_file
from layerjam.core.system import quote_word


@result
class NewBrake(Result):
    """Result of writing a new brake file."""

    name: str = fact("name of the new brake")
    file: str = fact("path of its file")

    def lines(self) -> Iterator[str]:
        """Yield the command to run next."""
        yield from ("", f"Edit it, then: layerjam show {quote_word(self.file)}")


@command("predict")
def new(
    name: Annotated[str, Help("Name of the new brake.", metavar="NAME")],
    start: Annotated[str | Path, Help("Brake to start from.", metavar="BRAKE", option="--from")],
    out: OutBrake,
    *,
    overwrite: Overwrite = False,
) -> NewBrake:
    """Write a commented brake file to edit, starting from an existing brake.

    Raises FileError if `out` exists and `overwrite` is not set, or if the name is not allowed.
    """
    # the title names the original brake; the user chooses the name of the new brake
    file = evolve(load(start), title="")
    text = file.render(name)
    BrakeFile.read(text, f"brake named '{name[:80]}'")
    store_file(out, text, overwrite)
    return NewBrake(name=name, file=str(out)).with_verdicts([file])
