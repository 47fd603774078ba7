"""`catalogue`: brakes, films, lines, designs and parts in the program, with their sources."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from layerjam.core.command.declare import command
from layerjam.core.command.results import Result, fact, result

Row = Mapping[str, str]
MOST_SOURCES = 3
"""Number of sources that a row names."""
TITLES = {
    "brakes": "brakes, for every command with a BRAKE",
    "films": "films, for --film and for [[film]] in a design",
    "lines": "vacuum lines",
    "designs": "specifications, for layerjam design",
    "pumps": "pumps, for a line's [pump]",
    "valves": "valves, for a line's [valve]",
    "sensors": "sensors",
}
"""{key: heading of its list}."""


@result
class Catalogue(Result):
    """Contents of the program, as rows of `name`, `title` and `source`.

    Iterating over it yields the names of the brakes.
    """

    brakes: Sequence[Row] = fact("brakes", listed=False)
    films: Sequence[Row] = fact("films", listed=False)
    lines_: Sequence[Row] = fact("vacuum lines", listed=False, key="lines")
    designs: Sequence[Row] = fact("specifications of designs", listed=False)
    pumps: Sequence[Row] = fact("pumps", listed=False)
    valves: Sequence[Row] = fact("valves", listed=False)
    sensors: Sequence[Row] = fact("sensors", listed=False)

    def __iter__(self) -> Iterator[str]:
        return (row["name"] for row in self.brakes)

    def __len__(self) -> int:
        return len(self.brakes)

    def __contains__(self, name: object) -> bool:
        return name in [*self]

    def __getitem__(self, index: int) -> str:
        return [*self][index]

    def lines(self) -> Iterator[str]:
        """Yield each list, one line for a name and one for its source."""
        for number, (key, title) in enumerate(TITLES.items()):
            yield from [""] * (number > 0)
            yield title
            for row in self.values[key]:
                yield f"  {row['name']}: {row['title']}"
                if row["source"]:
                    yield f"    {row['source']}"


@command("predict")
def catalogue() -> Catalogue:
    """List the brakes, films, lines, designs, pumps, valves and sensors that have a name.

    Each has its source. `layerjam show` prints the source of each number of a brake, and
    `layerjam parts NAME` those of a part.
    """
    from layerjam.brake.device.load import catalogue as brake_names
    from layerjam.brake.device.load import load
    from layerjam.brake.fluid.line_file import lines, load_line
    from layerjam.brake.fluid.parts import FAMILIES, parts
    from layerjam.workshop.design.specification import example_texts

    of_parts = {
        f"{family}s": [
            _make_row(part.name, part.title, (s.text for s in part.sources.values()))
            for part in parts(family).values()
        ]
        for family in FAMILIES
    }
    return Catalogue.create(
        of_parts,
        brakes=[_file_row(load(name)) for name in brake_names()],
        films=list(_film_rows()),
        lines_=[_file_row(load_line(name)) for name in lines()],
        designs=[_design_row(name, text) for name, text in example_texts().items()],
    )


def _make_row(name: str, title: str, sources: Iterable[str]) -> Row:
    """Return one row with its most frequent sources, without their sections and figures."""
    counts = Counter(re.split("[,;:]", text)[0] for text in sources if text)
    names = [text for text, _ in counts.most_common(MOST_SOURCES)]
    return {"name": name, "title": title, "source": "; ".join(names)}


def _file_row(file: Any) -> Row:
    sources = (s.text for s in file.sources.values() if s.kind not in ("assumed", "unstated"))
    return _make_row(file.name, file.title or file.name, sources)


def _film_rows() -> Iterator[Row]:
    from layerjam.brake.device.brake_file import materials
    from layerjam.core.toml_files.toml import parse_toml

    for name, text in materials()["films"].items():
        table = parse_toml(text, name)
        entries = [v for v in table.values() if isinstance(v, dict)]
        sources = (str(v.get("source", "")) for v in entries if v.get("kind") != "assumed")
        yield _make_row(name, str(table["name"]), sources)


def _design_row(name: str, text: str) -> Row:
    return {"name": name, "title": text.splitlines()[0].lstrip("# "), "source": ""}
