"""Pinned curves: what a chart showed once, kept as the call it came from and computed anew."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any

from nicegui import ui

from layerjam.commands.results import Result
from layerjam.errors import LayerjamError, QuantityError
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.desk import SHELVES, Desk, read_any
from layerjam.workbench.more import is_file, others
from layerjam.workbench.state import MEASURED, Pin
from layerjam.workbench.widgets import Alert, button, dressed, one_line

MOST = 8
"""Curves pinned to one page at most."""
COMMANDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"pull": ("tensile", "judder"), "drop": ("drop",), "vacuum": ("rise", "regulate")}
)
"""{page: commands whose curves can be pinned there}; a link may ask for no other."""
BAND = "band"
"""What a pin of a pull keeps besides options: how sure its law is, as `LawError.text` writes it."""
LINES = ("rise", "regulate")
"""Commands on a vacuum line; all others are on a brake."""


def pin_of(page: str, call: Call, text: str) -> Pin:
    """What keeps a call on a brake or line, whose catalogue name or TOML is `text`.

    Raises QuantityError for a call with a dropped file: it stays on this machine.
    """
    plain = {k: v for k, v in call.options.items() if isinstance(v, str | bool | int | float)}
    lost = call.options.keys() - plain.keys()
    if lost or call.files:
        what = ", ".join(sorted(lost)) or "a file"
        raise QuantityError(f"pin: {what} comes from a file you dropped, and no link keeps it")
    return Pin(page, call.name, text, plain)


def call_of(pin: Pin) -> Call:
    """The call that a pin keeps; QuantityError for what no page pins, such as a path in a link."""
    if pin.command not in COMMANDS.get(pin.page, ()):
        raise QuantityError(f"pin: nothing of '{pin.command[:40]}' is pinned on this page")
    known = {p.name for p in others(pin.command, ()) if not is_file(p)}
    options = {key: v for key, v in pin.options.items() if (pin.command, key) != ("tensile", BAND)}
    strange = sorted(options.keys() - known)
    if strange:
        raise QuantityError(f"pin: '{strange[0][:40]}' is no option that is kept")
    shelf = shelf_of(pin.command)
    file = read_any(shelf, pin.subject)
    named = pin.subject in SHELVES[shelf].names()
    subject = Subject(pin.subject) if named else Subject(f"{file.name}.toml", file)
    return Call(pin.command, (subject,), options)


def shelf_of(command: str) -> str:
    """What a command is called on: "brake" or "line"."""
    return "line" if command in LINES else "brake"


def labels(calls: Sequence[Call], shown: Call) -> list[str]:
    """What tells each call from what is shown, and from each other where that is not enough."""
    made = [_apart(call, [shown]) or _apart(call, calls) or "as shown" for call in calls]
    for place, label in enumerate(made):
        if made.count(label) > 1:
            made[place] = _apart(calls[place], [shown, *calls]) or label
    return [
        label if made.count(label) == 1 else f"{label} ({made[: place + 1].count(label)})"
        for place, label in enumerate(made)
    ]


def _apart(call: Call, from_these: Sequence[Call]) -> str:
    """The brake or line and the options that differ from any of some calls, as words."""
    name, words = call.subjects[0].name.removesuffix(".toml"), []
    if any(other.subjects != call.subjects for other in from_these):
        words.append(name)
    for key in dict.fromkeys(k for one in (call, *from_these) for k in one.options):
        value = call.options.get(key)
        if any(other.options.get(key) != value for other in from_these):
            said = key.replace("_", " ")
            words.append(said if value is True else f"no {said}" if value is None else str(value))
    return ", ".join(words)


def put_pin(desk: Desk, made: Pin) -> None:
    """Add a pin, unless it is there; QuantityError where a page has as many as it may."""
    pins = desk.state.pins
    if made in pins:
        return
    if sum(one.page == made.page for one in pins) >= MOST:
        raise QuantityError(f"pin: {MOST} curves are pinned; unpin one first")
    desk.put_pins((*pins, made))


def turn_file(desk: Desk, key: str) -> None:
    """Pin a dropped file to the pull, or take that back; QuantityError where there are enough."""
    made = Pin("pull", MEASURED, key)
    if made in desk.state.pins:
        desk.put_pins(tuple(pin for pin in desk.state.pins if pin != made))
    else:
        put_pin(desk, made)


@dataclass(frozen=True)
class Pinned:
    """A pinned curve: its place among the desk's pins, its label, its call and its result.

    `beside` is what the page computes besides for its pin, None where nothing.
    """

    place: int
    label: str
    call: Call
    result: Result
    beside: Any = None


class Pins:
    """The pins of one chart: computed once each, with a button to pin and one to unpin each."""

    def __init__(
        self, desk: Desk, page: str, now: Callable[[], Call | None], ident: str = "", only: str = ""
    ) -> None:
        """`now` is the call that the chart shows, if any.

        Where a page has several charts, `ident` names this one, for `only` one command.
        """
        self._desk, self._page, self._now = desk, page, now
        self._ident, self._only = ident or page, only
        self._known: dict[str, tuple[Result, Any]] = {}
        self.besides: Callable[[Pin, Result], Any] = lambda pin, result: None
        """What a page computes besides for a pin, once; may raise LayerjamError."""
        self._drawn: tuple[tuple[int, str], ...] = ()
        self.shown: tuple[Pinned, ...] = ()
        self.problem = ""

    @property
    def drawn(self) -> dict[str, Result]:
        """The pinned results that have a curve, by their labels."""
        return {one.label: one.result for one in self.shown if one.result.has_curve}

    @property
    def calls(self) -> dict[str, Call]:
        """The calls behind them."""
        return {one.label: one.call for one in self.shown if one.result.has_curve}

    @property
    def beside(self) -> dict[str, tuple[Call, Result]]:
        """Both, as a chart gives them away."""
        return {one.label: (one.call, one.result) for one in self.shown if one.result.has_curve}

    def compute(self, shown: Call) -> None:
        """The pinned results that can be drawn beside a call; in the page's thread."""
        kept: list[tuple[int, Call, tuple[Result, Any]]] = []
        known, trouble = {}, []
        for place, pin in enumerate(self._desk.state.pins):
            elsewhere = pin.page != self._page or (self._only and pin.command != self._only)
            if elsewhere or pin.command == MEASURED:
                continue
            key = json.dumps(asdict(pin), sort_keys=True)
            try:
                call = call_of(pin)
                known[key] = self._known.get(key) or self._computed(pin, call)
            except LayerjamError as err:
                trouble.append(one_line(err))
                continue
            if pin.command == shown.name:
                kept.append((place, call, known[key]))
        self._known = known
        named = labels([call for _, call, _ in kept], shown)
        self.shown = tuple(Pinned(p, n, c, *r) for (p, c, r), n in zip(kept, named, strict=True))
        self.problem = "; ".join(dict.fromkeys(trouble))

    def _computed(self, pin: Pin, call: Call) -> tuple[Result, Any]:
        result = call.run()
        return result, self.besides(pin, result)

    def build(self) -> None:
        """The button, and what is pinned."""
        with ui.row().classes("items-center gap-2"):
            tip = "Keep this curve as a quiet one, to compare with what comes next"
            button("Pin", self.pin, f"{self._ident}-pin", "push_pin", tip=tip)
            self._chips = dressed(ui.row().classes("items-center gap-2"), f"{self._ident}-pins")
        self._alert = Alert(f"{self._ident}-pin-problem", "text-sm")

    def pin(self, **more: str) -> None:
        """Keep what is shown now, and what is said `more` of it."""
        self._try(partial(self._pin_shown, more))

    def _pin_shown(self, more: Mapping[str, str]) -> None:
        call = self._now()
        if call is None:
            raise QuantityError("pin: no curve is shown")
        subject = getattr(self._desk.state, shelf_of(call.name))
        made = pin_of(self._page, call, subject)
        put_pin(self._desk, replace(made, options={**made.options, **more}))

    def pin_file(self, key: str) -> None:
        """Keep a dropped file's curve, or let it go."""
        self._try(partial(turn_file, self._desk, key))

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except LayerjamError as err:
            self._alert.say(one_line(err))
        else:
            self._alert.say("")

    def unpin(self, place: int) -> None:
        """Let one go."""
        pins = self._desk.state.pins
        self._desk.put_pins((*pins[:place], *pins[place + 1 :]))

    def fill(self, files: Mapping[str, str] = MappingProxyType({})) -> None:
        """Show what is pinned; nothing moves where it is the same.

        `files` is {key: label} of pinned files that are drawn.
        """
        drawn = tuple((one.place, one.label) for one in self.shown)
        for place, pin in enumerate(self._desk.state.pins):
            if pin.command == MEASURED and pin.subject in files:
                drawn = (*drawn, (place, files[pin.subject]))
        if self.problem:
            self._alert.say(self.problem)
        if drawn == self._drawn:
            return
        self._drawn = drawn
        self._chips.clear()
        with self._chips:
            for place, label in drawn:
                self._chip(place, label)

    def _chip(self, place: int, label: str) -> None:
        def away(_: Any = None) -> None:
            self.unpin(place)

        with ui.row().classes("items-center gap-0 no-wrap"):
            ui.label(label).classes("text-sm")
            look = "flat round dense size=sm"
            gone = button("", away, f"{self._ident}-unpin-{place}", "close", how=look)
            dressed(gone, aria_label=f"Unpin {label}")
