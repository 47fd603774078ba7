"""A machine's result as a folder: report.html, results.json and figures, whole or not at all."""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any

from layerjam._version import __version__
from layerjam.commands.declare import Progress
from layerjam.device.load import write_whole
from layerjam.errors import FileError
from layerjam.report.brake_files import plain
from layerjam.report.page import check_extras, drawn, page_style, svg_of
from layerjam.studies.machines.figures import pictures
from layerjam.studies.machines.verdict import Limit, Result
from layerjam.units import show

NAMES = ("report.html", "results.json")


def check_folder(out: Path, force: bool) -> None:
    """Raise FileError, or MissingExtraError, where no page could be written into `out`."""
    check_extras()
    if os.path.lexists(out) and not out.is_dir():
        raise FileError(out, "is a file, not a folder")
    for name in NAMES:
        if os.path.lexists(out / name) and not force:
            raise FileError(out / name, "exists already; --force replaces it")
    try:
        (out / "figures").mkdir(parents=True, exist_ok=True)
    except OSError as err:
        raise FileError(out, f"cannot be made: {err.strerror}") from None


def write(
    result: Result,
    values: Mapping[str, Any],
    out: Path,
    force: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Write the folder; gives the path of the page. `values` go into results.json as they are."""
    check_folder(out, force)
    made = {}
    planned = list(pictures(result))
    for index, picture in enumerate(planned):
        if progress is not None:
            progress(f"figure {picture.name}", (index + 1) / (len(planned) + 1))
        made[picture.name] = drawn(picture.figure())
        drawing = out / "figures" / f"{picture.name}.svg"
        write_whole(drawing, functools.partial(_fill, text=made[picture.name]), True)
    rows = json.dumps(plain(values), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_whole(out / "results.json", lambda p: _fill(p, rows), True)
    page = html(result, made)
    return write_whole(out / "report.html", lambda p: _fill(p, page), True)


def html(result: Result, drawings: Mapping[str, str]) -> str:
    """The page: no script, no outside address, pictures inside."""
    import jinja2

    place = files("layerjam.studies.machines")
    template = (place / "machine_page.html.j2").read_text(encoding="utf-8")
    env = jinja2.Environment(autoescape=True, trim_blocks=True, undefined=jinja2.StrictUndefined)
    scenario = result.scenario
    needed = "none does" if result.brakes_needed is None else str(result.brakes_needed)
    return env.from_string(template).render(
        title=f"{scenario.name}: {scenario.title}" if scenario.title else scenario.name,
        lead=f"A machine of Choi et al. 2018, Fig. 13, with brakes {scenario.brake.name}, computed "
        "from a model; nothing here was measured.",
        style=page_style(),
        feasible=result.feasible,
        verdict=result.verdict,
        numbers=[
            (show(result.mass, "kg"), "mass of the brakes of this scenario"),
            (needed, "brakes it would take"),
            (f"{sum(limit.met for limit in result.limits)} of {len(result.limits)}", "limits met"),
        ],
        limits=[_limit(limit) for limit in result.limits],
        figures=[
            {"svg": svg_of(drawings[p.name], p.name), "caption": p.caption}
            for p in pictures(result)
        ],
        results=[
            (k.replace("_", " "), _text(v, result.units.get(k, ""))) for k, v in result.own.items()
        ],
        notes=list(dict.fromkeys([*result.warnings, *scenario.warnings()])),
        sources=scenario.cited(),
        footer=f"layerjam {__version__}, {datetime.now(UTC).date().isoformat()}",
    )


def _limit(limit: Limit) -> dict[str, Any]:
    return {
        "name": limit.name,
        "value": show(limit.value, limit.unit),
        "side": "at least" if limit.least else "at most",
        "limit": show(limit.limit, limit.unit),
        "met": limit.met,
    }


def _text(value: Any, unit: str) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return show(float(value), unit or "1")
    return "; ".join(map(str, value)) if isinstance(value, list) else str(value)


def _fill(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
