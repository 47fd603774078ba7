"""Text of a new specification, with a comment on each key and every quantity that it may name."""

import re
import textwrap
from importlib.resources import files

from layerjam.workshop.design.merit import MERITS, VARIABLES
from layerjam.workshop.design.specification import example_texts


def format_specification(name: str, example: str) -> str:
    """Return the TOML text of an example under a new name, after comments that explain it."""
    body = example_texts()[example]
    body = re.sub(r"\A(?:#.*\n)+", "", body)
    body = re.sub(r'^name = ".*"$', f'name = "{name}"', body, flags=re.MULTILINE)
    merits, variables = (
        "\n".join(_describe(key, spec.text, spec.unit) for key, spec in specs.items())
        for specs in (MERITS, VARIABLES)
    )
    head = (files("layerjam.workshop.design") / "new.txt").read_text(encoding="utf-8")
    return head.format(name=name, merits=merits, variables=variables) + body


def _describe(key: str, text: str, unit: str) -> str:
    words = f"{text} [{unit}]" if unit != "1" else text
    return textwrap.fill(
        words, 96, initial_indent=f"#   {key:<20} ", subsequent_indent=f"#   {'':<20} "
    )
