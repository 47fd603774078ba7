"""Sliders, numbers and choices that take name, unit, bounds and help from what they edit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from nicegui import ui

from layerjam.errors import QuantityError
from layerjam.units import QuantitySpec, exact_text, show, unit_factor, usual_unit
from layerjam.workbench.desk import Desk
from layerjam.workbench.live import Bar


@dataclass(frozen=True)
class Control:
    """A quantity a page asks for. `low` to `high` [SI] is the slider's way, within the bounds."""

    key: str
    spec: QuantitySpec
    default: float
    low: float
    high: float
    unit: str = ""
    label: str = ""
    steps: int = 400

    @property
    def shown_unit(self) -> str:
        """The unit on the page."""
        return self.unit or usual_unit(self.spec.unit)

    @property
    def factor(self) -> float:
        """SI value of one shown unit."""
        return float(unit_factor(self.shown_unit, self.spec.unit) or 1) if self.shown_unit else 1

    @property
    def name(self) -> str:
        """What stands before the slider."""
        return self.label or self.key.replace("_", " ").capitalize()

    @property
    def help(self) -> str:
        """QuantitySpec and bounds, as a sentence."""
        return f"{self.spec.text}: {self.spec.allowed()}"

    def text(self, value: float) -> str:
        """The value as the verbs take it, with its unit."""
        return exact_text(value, self.spec.unit)

    @property
    def digits(self) -> int:
        """Digits behind the point, in the shown unit, that tell the slider's steps apart."""
        step = (self.high - self.low) / self.steps / self.factor
        return max(0, -int(f"{step:e}".split("e")[1]))

    def rounded(self, value: float) -> float:
        """The SI value of the nearest step of the slider, short in the shown unit."""
        return float(f"{value / self.factor:.{self.digits}f}") * self.factor


@dataclass(frozen=True)
class Choice:
    """One of several words; `words` maps what is set to what is shown."""

    key: str
    words: Mapping[str, str]
    default: str
    label: str = ""
    help: str = ""

    @property
    def name(self) -> str:
        """What stands before it."""
        return self.label or self.key.replace("_", " ").capitalize()


def number(desk: Desk, page: str, control: Control) -> float:
    """The control's value [SI]; what a link brought is checked, else the default stands."""
    value = desk.get(page, control.key, control.default)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return control.default
    try:
        return control.spec.check(float(value), control.name)
    except QuantityError:
        return control.default


def word(desk: Desk, page: str, choice: Choice) -> str:
    """The choice's value, the default where a link brought none that exists."""
    value = desk.get(page, choice.key, choice.default)
    return value if isinstance(value, str) and value in choice.words else choice.default


def slider(
    desk: Desk, page: str, control: Control, renew: Callable[[], Control] | None = None
) -> None:
    """Label, slider and number; wrong numbers are refused in words below, nothing is changed.

    `renew` gives the control anew, with other bounds, after another brake or line was taken.
    """
    factor = control.factor
    ident = f"{page}-{control.key}"
    with ui.column().classes("w-full gap-0"):
        with ui.row().classes("w-full items-center justify-between no-wrap"):
            ui.label(control.name).classes("text-sm").tooltip(control.help)
            field = ui.input().props(
                f'dense outlined input-class="text-right" suffix="{control.shown_unit}" '
                f'aria-label="{control.name} [{control.shown_unit}]" data-testid="{ident}-number" '
                'hide-bottom-space'
            ).classes("w-36")  # fmt: skip
        bar = Bar(min=0, max=1).props(f'aria-label="{control.name}" data-testid="{ident}" dense')
    bar.beside(field)
    filling = False

    def span() -> None:
        low, high = control.low / factor, control.high / factor
        bar.way(low, high, (high - low) / control.steps, control.digits)

    def fill() -> None:
        nonlocal filling
        filling = True
        value = number(desk, page, control)
        bar.set_value(min(max(value, control.low), control.high) / factor)
        field.set_value(f"{value / factor:.6g}")
        field.error = None
        filling = False

    def moved(event: object) -> None:
        if filling:
            return
        field.error = None
        desk.put(page, control.key, control.rounded(float(event.value) * factor))  # type: ignore[attr-defined]

    def typed() -> None:
        text = str(field.value or "").strip()
        try:
            float(text)
            text = f"{text} {control.shown_unit}".strip()
        except ValueError:
            pass
        try:
            value = control.spec.read(text, control.name)
        except QuantityError as err:
            field.error = str(err)
            return
        # leaving a field that was not touched is no step of undo
        if value != number(desk, page, control):
            desk.put(page, control.key, value)
        fill()

    def watch(what: str) -> None:
        nonlocal control
        if what not in ("undo", "brake", "line"):
            return
        if renew is not None:
            control = renew()
            span()
        fill()

    bar.on_value_change(moved)
    field.on("keydown.enter", typed)
    field.on("blur", typed)
    desk.watch(watch)
    span()
    fill()


def choice(desk: Desk, page: str, what: Choice) -> None:
    """A row of words to choose from."""
    with ui.row().classes("w-full items-center justify-between"):
        ui.label(what.name).classes("text-sm").tooltip(what.help or what.name)
        toggle = ui.toggle(
            dict(what.words), value=word(desk, page, what),
            on_change=lambda e: desk.put(page, what.key, str(e.value)),
        ).props(
            f'dense no-caps aria-label="{what.name}" data-testid="{page}-{what.key}"'
        )  # fmt: skip

    def fill(_: str) -> None:
        if toggle.value != word(desk, page, what):
            toggle.set_value(word(desk, page, what))

    desk.watch(lambda changed: fill(changed) if changed == "undo" else None)


def menu(desk: Desk, page: str, what: Choice) -> None:
    """A list of words to choose from that opens; for more words than fit a row."""
    box = ui.select(
        dict(what.words), value=word(desk, page, what), label=what.name,
        on_change=lambda e: desk.put(page, what.key, str(e.value)),
    ).props(
        f'dense outlined options-dense aria-label="{what.name}" data-testid="{page}-{what.key}"'
    ).classes("w-full")  # fmt: skip
    if what.help:
        box.tooltip(what.help)

    def fill(changed: str) -> None:
        if changed == "undo" and box.value != word(desk, page, what):
            box.set_value(word(desk, page, what))

    desk.watch(fill)


def readout(value: float | None, unit: str) -> str:
    """A number as it stands in a table of results."""
    return "–" if value is None else show(value, unit)
