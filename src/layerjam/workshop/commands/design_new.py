"""`design new`: a commented specification to edit."""

import re
import textwrap
from collections.abc import Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Literal

from layerjam.brake.commands.arguments import Overwrite
from layerjam.core.command.declare import Help, OutFile, command
from layerjam.core.command.results import Result, fact, result
from layerjam.core.errors import QuantityError
from layerjam.core.store import store_file
from layerjam.core.system import quote_word
from layerjam.core.units import QuantitySpec


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
    from layerjam.workshop.design.merit import MERITS, VARIABLES
    from layerjam.workshop.design.specification import example_texts

    if plain_name(name) != name:
        raise QuantityError.of("name", f"'{name[:60]}' is not allowed; use '{plain_name(name)}'")
    head = (files("layerjam.workshop.design") / "new.txt").read_text(encoding="utf-8")
    head = head.format(name=name, merits=_describe(MERITS), variables=_describe(VARIABLES))
    body = re.sub(r"\A(?:#.*\n)+", "", example_texts()[start])
    body = re.sub(r'^name = ".*"$', f'name = "{name}"', body, flags=re.MULTILINE)
    path = store_file(out or f"{name}.toml", head + body, overwrite)
    return NewSpecification(name=name, file=str(path))


def _describe(specs: Mapping[str, QuantitySpec]) -> str:
    """Return a comment for each quantity, with its unit."""
    lines = []
    for key, spec in specs.items():
        words = f"{spec.text} [{spec.unit}]" if spec.unit != "1" else spec.text
        start, indent = f"#   {key:<20} ", f"#   {'':<20} "
        lines.append(textwrap.fill(words, 96, initial_indent=start, subsequent_indent=indent))
    return "\n".join(lines)
