"""`design new`: a commented specification to edit."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from layerjam.brake.commands.arguments import Overwrite
from layerjam.core.command.declare import Help, OutFile, command
from layerjam.core.command.results import Result, fact, result
from layerjam.core.errors import QuantityError
from layerjam.core.store import store_file
from layerjam.core.system import quote_word


@result
class NewSpecification(Result):
    """Result of writing a new specification."""

    name: str = fact("name of the specification")
    file: str = fact("path of its file")

    def lines(self) -> Iterator[str]:
        """Yield the command to run next."""
        target = quote_word(f"{Path(self.file).stem}-brake.toml")
        yield from ("", "Edit it, then:")
        yield f"  layerjam design {quote_word(self.file)} --out {target}"


@command("design", parent="design")
def design_new(
    name: Annotated[str, Help("Name of the new specification.", metavar="NAME")],
    start: Annotated[
        Literal["wrist", "stop"],
        Help("Example to start from.", option="--from"),
    ] = "wrist",
    *,
    out: Annotated[
        str | Path | None,
        OutFile("File to write; NAME.toml if omitted.", metavar="FILE.toml", endings=(".toml",)),
    ] = None,
    overwrite: Overwrite = False,
) -> NewSpecification:
    """Write a commented specification to edit, starting from an example.

    Raises FileError if the file exists and `overwrite` is not set, and QuantityError for a name
    that is not allowed.
    """
    from layerjam.workshop.design.design_file import plain_name
    from layerjam.workshop.design.new import format_specification

    if plain_name(name) != name:
        raise QuantityError.of("name", f"'{name[:60]}' is not allowed; use '{plain_name(name)}'")
    path = store_file(out or f"{name}.toml", format_specification(name, start), overwrite)
    return NewSpecification(name=name, file=str(path))
