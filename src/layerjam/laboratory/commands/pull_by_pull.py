"""The table of pulls that commands print: rows for JSON, lines of text, and notices."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from layerjam.core.errors import Notice
from layerjam.core.units import show

if TYPE_CHECKING:
    from layerjam.laboratory.identify.single_pulls import SinglePull

HEADS = ("vacuum", "speed", "factor", "stiffness", "shape", "seating", "verdict", "file")
TITLE = "pull by pull"
NONE = "-"


def make_pull_rows(pulls: "Sequence[SinglePull]") -> list[dict[str, Any]]:
    """Return the rows in the form of the `pulls` key, in SI units."""
    return [{**asdict(pull), "odd": pull.is_outlier} for pull in pulls]


def format_cells(row: Mapping[str, Any]) -> list[str]:
    """Return a row as text, in the order of `HEADS`."""

    def format_share(value: float | None) -> str:
        return NONE if value is None else f"{value:+.1%}"

    outlier_tests = [test for test, verdict in row["verdicts"].items() if verdict == "odd"]
    factor, stiffness = row["factor"], row["stiffness"]
    return [
        show(row["vacuum"], "Pa"),
        NONE if row["speed"] is None else show(row["speed"], "m/s", 3),
        NONE if factor is None else f"{factor:.4f}",
        NONE if stiffness is None else show(stiffness, "N/m", 3),
        format_share(row["shape"]),
        format_share(row["seating"]),
        ", ".join(outlier_tests) or "ok",
        row["file"],
    ]


def format_pull_table(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the lines of the table; none for a single pull, which has no others to compare with."""
    if len(rows) < 2:
        return
    table = [list(HEADS), *(format_cells(row) for row in rows)]
    widths = [max(len(line[place]) for line in table) for place in range(len(HEADS) - 1)]
    yield from ("", TITLE)
    for line in table:
        texts = [f"{text:<{width}}" for text, width in zip(line, widths, strict=False)]
        yield "  ".join([*texts, line[-1]])


def condition_notices(pulls: "Sequence[SinglePull]") -> Iterator[Notice]:
    """Yield a notice if all pulls have the same vacuum or speed."""
    from layerjam.laboratory.identify.single_pulls import find_common_conditions

    words = {"vacuum": ("Pa", "vacuums"), "speed": ("m/s", "speeds")}
    for quantity, value in find_common_conditions(pulls).items():
        unit, other_words = words[quantity]
        yield Notice(
            f"only one {quantity}, {show(value, unit, 3)}: these pulls do not show "
            f"whether the friction is the same at other {other_words}",
            f"one-{quantity}",
        )
