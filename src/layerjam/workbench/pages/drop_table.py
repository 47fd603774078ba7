"""The table of the page Drop: the same drop with no brake, at full vacuum, tuned, and so on."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from types import MappingProxyType

from layerjam.workbench.answer import Answer
from layerjam.workbench.call import result_fields

MODES = MappingProxyType(
    {
        "none": "no brake",
        "full": "full",
        "tuned": "tuned",
        "value": "a value",
        "history": "a history",
    }
)
ROWS = (
    "outcome",
    "vacuum",
    "slip",
    "peak_force",
    "peak_deceleration",
    "peak_g",
    "crash_force",
    "crash_g",
    "stopping_time",
    "end_speed",
    "dissipated_energy",
)
"""These come first; below them stands what else a stop has to say."""
LEFT_OUT = ("feasible", "reason", "speed", "accelerometer", "filter")
OUTCOMES = MappingProxyType(
    {
        "STOPPED": "stopped",
        "NEVER_SLID": "stopped without slip",
        "SNAPS": "snaps",
        "BOTTOMED_OUT": "bottomed out",
        "FINISHED": "still moving",
    }
)


Drops = Mapping[str, Answer]
"""{mode: answer}."""


def notes(drops: Drops) -> list[str]:
    """Warnings of the drops, each with whose it is unless all drops of the brake say it."""
    said = {mode: one.result.warnings for mode, one in drops.items() if one.result is not None}
    by_brake = [warnings for mode, warnings in said.items() if mode != "none"]
    made = []
    for mode, warnings in said.items():
        for w in warnings:
            shared = all(w in other for other in by_brake)
            made.append(w if shared else f"{MODES[mode]}: {w}")
    return list(dict.fromkeys(made))


def table(drops: Drops, shown: str) -> str:
    """HTML of the table; what cannot be says so across its column."""
    stops = {mode: answer.result for mode, answer in drops.items()}
    fine = {mode: dict(stop.rows()) for mode, stop in stops.items() if stop and stop.feasible}
    named = {key.replace("_", " ") for key in LEFT_OUT}
    names = [key.replace("_", " ") for key in ROWS]
    names += [n for texts in fine.values() for n in texts if n not in named]
    names = list(dict.fromkeys(names))
    about = result_fields("drop")
    rows = []
    for i, name in enumerate(names):
        key = name.replace(" ", "_")
        what = escape(about.get(key, ""))
        cells = [f'<th scope="row" title="{what}">{escape(name.capitalize())}</th>']
        for mode, stop in stops.items():
            if mode in fine:
                ident = f'data-testid="drop-{mode}-{key}"'
                text = _cell(key, fine[mode].get(name, "–"))
                cells.append(f"<td{_mark(mode, shown)} {ident}>{escape(text)}</td>")
            elif i == 0:
                why = drops[mode].refusal if stop is None else str(stop.reason)
                ident = f'data-testid="drop-{mode}-outcome"'
                said = f"cannot: {escape(why)}"
                cells.append(f'<td rowspan="{len(names)}" class="cannot" {ident}>{said}</td>')
        rows.append(f"<tr>{''.join(cells)}</tr>")
    heads = [f'<th scope="col"{_mark(m, shown)}>{escape(MODES[m])}</th>' for m in drops]
    return (
        '<table class="drop-table"><caption class="sr-only">The same drop with no brake, at full '
        f"vacuum and tuned</caption><thead><tr><td></td>{''.join(heads)}</tr></thead>"
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _mark(mode: str, shown: str) -> str:
    return ' class="shown"' if mode == shown else ""


def _cell(key: str, text: str) -> str:
    return OUTCOMES.get(text, text) if key == "outcome" else text.replace("^2", "²")
