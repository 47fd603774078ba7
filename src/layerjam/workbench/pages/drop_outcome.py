"""What a drop came to, in sentences, and buttons that apply what the tuning advises."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from nicegui import ui

from layerjam.units import show
from layerjam.workbench.desk import Desk
from layerjam.workbench.heroes import Hero
from layerjam.workbench.resized import with_sheets
from layerjam.workbench.widgets import button


def verdict(stop: Any | None, refusal: str) -> str:
    """What happened, in a sentence."""
    if stop is None:
        return f"Cannot: {refusal.rstrip('.')}."
    if not stop.feasible:
        return f"Cannot: {str(stop.reason).rstrip('.')}."
    if stop.outcome == "BOTTOMED_OUT":
        return _crashed(stop)
    if stop.outcome is None:
        return _sentence(str(stop.reason))
    if stop.stopping_time is None:
        return "The mass still moves when the time to follow it is over."
    after = f"in {show(stop.stopping_time, 's')}"
    if stop.outcome == "NEVER_SLID":
        return f"Stopped {after} by the rope alone: the sheets never slid."
    if stop.outcome == "CLOSED_BY_SLEEVE":
        return f"The enclosure pulls the brake shut {after}: friction no longer holds it."
    if stop.slip is None:
        return f"Stopped {after} by the rope, without a brake."
    return f"Stopped {after}, after {show(stop.slip, 'm')} of slip."


def _crashed(stop: Any) -> str:
    """How far it got, how fast it still was, and how hard the end of the travel is."""
    used = f"The travel of {show(stop.slip, 'm')} is used up with the mass still at "
    used += f"{show(stop.end_speed, 'm/s')}: it crashes"
    if stop.crash_force is None:
        return f"{used}. How hard is not known: without a rope nothing says what gives."
    hard = show(stop.crash_force, "N")
    felt = "" if stop.crash_g is None else f", {show(stop.crash_g, '1', 3)} g"
    return f"{used}, with up to {hard}{felt} if the end does not give."


def _sentence(words: str) -> str:
    """With a capital and a full stop."""
    return f"{words[:1].upper()}{words[1:].rstrip('.')}."


GOOD = ("STOPPED", "NEVER_SLID")
"""Outcomes in which the mass was stopped."""


def heroes(stop: Any | None) -> list[Hero]:
    """What a drop is looked at for; a crash counts into the peak, where it is known."""
    if stop is None or not stop.feasible or stop.peak_force is None:
        return []
    crashed = stop.outcome == "BOTTOMED_OUT"
    peak, g = stop.peak_force, stop.peak_g
    name = "Peak"
    if crashed:
        name = "Peak, if the end is rigid" if stop.crash_force else "Peak before the crash"
        peak, g = stop.crash_force or peak, stop.crash_g or g
    made = [("hero-peak", name, show(peak, "N") if g is None else f"{show(g, '1', 3)} g")]
    if stop.slip is not None:
        made.append(("hero-slip", "Slip of the brake", show(stop.slip, "m")))
    if crashed:
        made.append(("hero-end-speed", "Speed at the crash", show(stop.end_speed, "m/s")))
    elif stop.stopping_time is not None:
        made.append(("hero-time", "Stands still after", show(stop.stopping_time, "s")))
    return made


class Advice:
    """Buttons that set what would stop the mass; each of them was tuned before it is named."""

    def __init__(self, desk: Desk, rope: Callable[[], float | None]) -> None:
        """`rope` is the stiffness of the rope on the page [N/m], None without one."""
        self._desk, self._rope = desk, rope
        self._shown: tuple[Any, ...] = ()
        self._row = ui.row().classes("items-center gap-2")
        self._row.props["data-testid"] = "drop-advice"

    def fill(self, tuned: Any | None, mass: float, failed: bool) -> None:
        """What a tuning found; nothing where the drop did not fail."""
        ways: list[tuple[str, str, Callable[[], None]]] = []
        if failed and tuned is not None:
            ways = list(self._ways(tuned, mass))
        names = tuple((text, tip) for text, tip, _ in ways)
        if names == self._shown:
            return
        self._shown = names
        self._row.clear()
        with self._row:
            if ways:
                ui.label("What would stop it").classes("text-sm")
            for key, (text, tip, act) in enumerate(ways):
                button(text, act, f"drop-advice-{key}", tip=tip)

    def _ways(self, found: Any, mass: float) -> Any:
        put = self._put
        if found.feasible:
            there = f"{show(found.vacuum, 'Pa')} of vacuum"
            yield there, "The vacuum that is tuned to the travel", partial(put, shown="tuned")
        if found.sheets_needed is not None:
            count = int(found.sheets_needed)
            tip = "The same brake with as many sheets"
            yield f"{count} sheets", tip, partial(with_sheets, self._desk, count)
        if found.brakes_needed is not None:
            count, rope = int(found.brakes_needed), self._rope()
            share = {"mass": mass / count}
            if rope is not None:
                share["rope_stiffness"] = rope / count
            tip = f"Side by side: shows one of them, with 1/{count} of the mass and of the rope"
            yield f"{count} brakes", tip, partial(put, shown="tuned", **share)
        if found.travel_needed is not None:
            far = float(found.travel_needed)
            said = f"{show(far, 'm')} of travel"
            yield said, "Stop within another travel", partial(put, shown="tuned", travel=far)

    def _put(self, **settings: Any) -> None:
        self._desk.put_all("drop", settings)
