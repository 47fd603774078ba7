"""`parts` on the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from layerjam.cli import options as opt

if TYPE_CHECKING:
    from layerjam.fluid.parts import Part


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("parts")(parts)


def parts(
    name: Annotated[
        str | None, typer.Argument(metavar="[PART]", help="One part, with its sources in full.")
    ] = None,
    as_json: opt.AsJson = False,
) -> int:
    """Pumps, valves and sensors of the catalogue, for a line's file."""
    from layerjam.cli.old_output import say
    from layerjam.commands import parts as verb

    answer = verb.parts(name)
    lines = _listed(answer.record) if name is None else _told(answer.record[0])
    return say(answer, as_json, hidden=tuple(answer.values), lines=lines)


def _listed(records: list[Part]) -> list[str]:
    """A heading for each family; name, what is known and what is assumed of each part."""
    out: list[str] = []
    for family in dict.fromkeys(p.family for p in records):
        out += ["", f"{family}s"] if out else [f"{family}s"]
        for part in (p for p in records if p.family == family):
            out.append(f"  {part.name}: {part.title}")
            known, guessed = _numbers(part, False), _numbers(part, True)
            without = [] if part.missing is None else [f"no {part.missing} printed"]
            out.append(f"    {', '.join(known + without)}")
            out += [f"    assumed: {', '.join(guessed)}"] if guessed else []
    return out


def _numbers(part: Part, guessed: bool) -> list[str]:
    out = [
        f"{key.replace('_', ' ')} {_number(key, value)}"
        for key, value in part.values.items()
        if (part.sources[key].kind == "assumed") is guessed and key != "curve"
    ]
    if "curve" not in part.values:
        return out
    if part.sources["curve"].kind != "assumed":
        return out if guessed else [f"curve {_number('curve', part.values['curve'])}", *out]
    if guessed:
        return ["flow straight between these two", *out]
    ends = ("free_flow", "ultimate_vacuum")
    return [f"{k.replace('_', ' ')} {_number(k, part.printed[k])}" for k in ends] + out


def _told(part: Part) -> list[str]:
    """Every number with its source."""
    out = [f"{part.title} ({part.name}, {part.kind})"]
    for key, value in {**part.values, **part.printed}.items():
        out.append(f"  {key.replace('_', ' ')}: {_number(key, value)}")
        out.append(f"    {part.sources[key].sentence()}")
    if part.missing is not None:
        out.append(f"  no {part.missing}: a line's file gives it beside the part")
    return [*out, *([f"  {part.note}"] if part.note else [])]


def _number(key: str, value: Any) -> str:
    from layerjam.commands.parts import UNITS
    from layerjam.units import show

    if key == "curve":
        return " to ".join(f"{show(f, 'm^3/s')} at {show(v, 'Pa')}" for v, f in value)
    return show(float(value), UNITS[key])
