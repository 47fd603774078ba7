"""`parts`: catalogue of pumps, valves and sensors for a vacuum line."""

from collections.abc import Iterator
from typing import Annotated, Any

from layerjam.brake.fluid.parts import FAMILIES, PRINTED, Part, family_fields
from layerjam.brake.fluid.parts import parts as known_parts
from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Result, fact, result
from layerjam.core.errors import UnknownNameError
from layerjam.core.units import show

UNITS = {
    **{name: spec.unit for name, spec in PRINTED.items()},
    **{n: m.unit for family in FAMILIES for n, m in family_fields(family).items()},
    "curve": "Pa, m^3/s",
}


@result
class PartList(Result):
    """Parts in the catalogue; `record` contains them as Part.

    Each is a mapping: `name` (as in a line's file), `title`, `kind`, `numbers` (fields of the line,
    including assumed ones), `printed` (other published data), `sources` (a sentence for each),
    `missing` (the number that a line needs in addition, or None) and `note`.
    """

    record: list[Part]
    pumps: list[dict[str, Any]] = fact("pumps", listed=False)
    valves: list[dict[str, Any]] = fact("valves", listed=False)
    sensors: list[dict[str, Any]] = fact("sensors", listed=False)
    full: bool = False

    @property
    def units(self) -> dict[str, str]:
        """Return {key: SI unit} of every number of these parts."""
        used = {key for part in self.record for key in (*part.values, *part.printed)}
        return {key: unit for key, unit in UNITS.items() if key in used}

    def lines(self) -> Iterator[str]:
        """Yield a line or two for each part; a single part is listed with all of its sources."""
        if self.full:
            for part in self.record:
                yield from _detail_lines(part)
            return
        family = ""
        for part in self.record:
            if part.family != family:
                yield from ([""] if family else [])
                family = part.family
                yield f"{family}s"
            yield from _summary_lines(part)


@command("vacuum")
def parts(
    name: Annotated[
        str | None, Help("Part to print with its full sources.", metavar="PART")
    ] = None,
) -> PartList:
    """List pumps, valves and sensors in the catalogue, with their numbers in SI and their sources.

    Raises UnknownNameError.
    """
    families = {family: dict(known_parts(family)) for family in FAMILIES}
    if name is not None:
        every = [name_of_part for family in families.values() for name_of_part in family]
        if name not in every:
            raise UnknownNameError("part", name, every)
        families = {
            f: {n: p for n, p in family.items() if n == name} for f, family in families.items()
        }
    return PartList.create(
        {f"{f}s": [_part_row(part) for part in family.values()] for f, family in families.items()},
        record=[part for family in families.values() for part in family.values()],
        full=name is not None,
    )


def _part_row(part: Part) -> dict[str, Any]:
    return {
        "name": part.name,
        "title": part.title,
        "kind": part.kind,
        "numbers": dict(part.values),
        "printed": dict(part.printed),
        "sources": {key: source.sentence() for key, source in part.sources.items()},
        "missing": part.missing,
        "note": part.note or None,
    }


def _summary_lines(part: Part) -> Iterator[str]:
    yield f"  {part.name}: {part.title}"
    numbers, assumed_numbers = _format_part_values(part, False), _format_part_values(part, True)
    missing_number = [] if part.missing is None else [f"{part.missing} not published"]
    yield f"    {', '.join(numbers + missing_number)}"
    if assumed_numbers:
        yield f"    assumed: {', '.join(assumed_numbers)}"


def _format_part_values(part: Part, guessed: bool) -> list[str]:
    out = [
        f"{key.replace('_', ' ')} {_format_number(key, value)}"
        for key, value in part.values.items()
        if (part.sources[key].kind == "assumed") is guessed and key != "curve"
    ]
    if "curve" not in part.values:
        return out
    if part.sources["curve"].kind != "assumed":
        return out if guessed else [f"curve {_format_number('curve', part.values['curve'])}", *out]
    if guessed:
        return ["flow assumed linear between these two", *out]
    ends = ("free_flow", "ultimate_vacuum")
    return [f"{k.replace('_', ' ')} {_format_number(k, part.printed[k])}" for k in ends] + out


def _detail_lines(part: Part) -> Iterator[str]:
    yield f"{part.title} ({part.name}, {part.kind})"
    for key, value in {**part.values, **part.printed}.items():
        yield f"  {key.replace('_', ' ')}: {_format_number(key, value)}"
        yield f"    {part.sources[key].sentence()}"
    if part.missing is not None:
        yield f"  {part.missing} not published: state it in the line file, next to the part"
    if part.note:
        yield f"  {part.note}"


def _format_number(key: str, value: Any) -> str:
    if key == "curve":
        return " to ".join(f"{show(f, 'm^3/s')} at {show(v, 'Pa')}" for v, f in value)
    return show(float(value), UNITS[key])
