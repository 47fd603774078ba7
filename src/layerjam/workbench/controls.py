"""Sliders, number fields and choices, with each quantity's name, unit, bounds and help."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from nicegui import ui

from layerjam.core.conversion import unit_factor
from layerjam.core.errors import QuantityError
from layerjam.core.units import QuantitySpec, exact_text, parse, show, usual_unit
from layerjam.workbench.call import parameters
from layerjam.workbench.desk import Desk
from layerjam.workbench.live import Bar, Field
from layerjam.workbench.spoken import page_text
from layerjam.workbench.state import shared_setting
from layerjam.workbench.widgets import button, dress, select


@dataclass(frozen=True)
class Control:
    """A quantity that a page asks for; the slider spans `low` to `high` [SI], within the bounds."""

    key: str
    spec: QuantitySpec
    default: float
    low: float
    high: float
    unit: str = ""
    label: str = ""
    steps: int = 400
    text_of: str = ""

    @property
    def display_unit(self) -> str:
        """Unit of the quantity on the page."""
        return self.unit or usual_unit(self.spec.unit)

    @property
    def factor(self) -> float:
        """SI value of one unit of the page."""
        unit = self.display_unit
        return float(unit_factor(unit, self.spec.unit) or 1) if unit else 1

    @property
    def name(self) -> str:
        """Label of the slider."""
        return self.label or self.key.replace("_", " ").capitalize()

    @property
    def help(self) -> str:
        """Return the meaning and the bounds as a sentence."""
        return f"{(self.text_of or self.spec.text).rstrip('.,')}: {self.spec.limits()}"

    def text(self, value: float) -> str:
        """Return the value as text with its unit, for the commands."""
        return exact_text(value, self.spec.unit)

    @property
    def digits(self) -> int:
        """Number of decimals, in the page's unit, needed to distinguish the slider's steps."""
        step = (self.high - self.low) / self.steps / self.factor
        return max(0, -int(f"{step:e}".split("e")[1]))

    def round_to_step(self, value: float) -> float:
        """Return a slider's SI value, rounded to `digits` decimals in the page's unit."""
        return float(f"{value / self.factor:.{self.digits}f}") * self.factor

    def nearest_value(self, text: str) -> float | None:
        """Return the allowed value [SI] nearest to a typed one; None if it is not a number."""
        try:
            value = parse(add_unit(text, self.display_unit), self.spec.unit, self.name)
        except QuantityError:
            return None
        return min(max(value, self.low if self.spec.open_lo else self.spec.lo), self.spec.hi)

    def narrow_bounds(self, low: float | None = None, high: float | None = None) -> "Control":
        """Return the same control with narrower bounds [SI]; values outside are rejected."""
        lo = self.spec.lo if low is None else low
        hi = self.spec.hi if high is None else high
        default = max(min(self.default, hi), lo)
        return replace(self, spec=replace(self.spec, lo=lo, hi=hi), default=default)


def control(
    command: str, name: str, default: float, span: tuple[float, float], **more: Any
) -> Control:
    """Return the control for one parameter of a command, with its declared meaning and bounds."""
    parameter = parameters(command)[name]
    if parameter.spec is None:
        raise TypeError(f"{command} declares no quantity called {name}")
    key = more.pop("key", name)
    return Control(key, parameter.spec, default, *span, text_of=parameter.help.text, **more)


USUAL_VACUUM = 94.5e3
"""Initial vacuum of all pages [Pa], as in the paper's pulls."""


def vacuum_control(command: str, name: str, full: float, low: float = 0.0, **more: Any) -> Control:
    """Return the control for the shared vacuum, from `low` to full vacuum at the site [Pa]."""
    span = (low, full)
    return control(command, name, min(USUAL_VACUUM, full), span, **more).narrow_bounds(high=full)


def map_keys(*controls: Control) -> dict[str, Control]:
    """Return {key: control}."""
    return {control.key: control for control in controls}


@dataclass(frozen=True)
class Choice:
    """A choice among options; `words` maps each stored value to its displayed text."""

    key: str
    words: Mapping[str, str]
    default: str
    label: str = ""
    help: str = ""

    @property
    def name(self) -> str:
        """Label of the choice."""
        return self.label or self.key.replace("_", " ").capitalize()


def make_choice(command: str, name: str, words: Mapping[str, str], **more: str) -> Choice:
    """Return the choice for one parameter of a command; `words` describes the options."""
    parameter = parameters(command)[name]
    labels = {word: words.get(word, word.replace("-", " ")) for word in parameter.words}
    default = more.pop("default", "") or parameter.default_text or parameter.words[0]
    return Choice(name, labels, default, help=more.pop("help", "") or parameter.sentence, **more)


def read_number(desk: Desk, page: str, control: Control) -> float:
    """Return the control's value [SI]; an invalid value from a link is replaced by the default."""
    value = desk.get(page, control.key, control.default)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return control.default
    try:
        return control.spec.check(float(value), control.name)
    except QuantityError:
        return control.default


def read_word(desk: Desk, page: str, choice: Choice) -> str:
    """Return the choice's value, or the default if a link contains an invalid one."""
    value = desk.get(page, choice.key, choice.default)
    return value if isinstance(value, str) and value in choice.words else choice.default


class Slider:
    """Label, slider and number field; an invalid number shows an error and changes nothing.

    `renew` returns the control with new bounds after a change of brake or line.
    """

    def __init__(
        self, desk: Desk, page: str, control: Control, renew: Callable[[], Control] | None = None
    ) -> None:
        self.desk, self.page, self.control = desk, page, control
        self._renew, self._filling = renew, False
        self._remedy: ui.button | None = None
        self._refusal: tuple[str, float | None] = ("", None)
        ident = f"{page}-{control.key}"
        with ui.column().classes("w-full gap-0") as self._box:
            with ui.row().classes("w-full items-center justify-between no-wrap"):
                ui.label(control.name).classes("text-sm").tooltip(page_text(control.help))
                self.field = number_field(f"{control.name} [{control.display_unit}]", "w-36")
                dress(self.field, f"{ident}-number", suffix=control.display_unit)
            bar = Bar(min=0, max=1)
            self.bar = dress(bar, ident, look="dense", aria_label=control.name)
        self.bar.mirror_value(self.field)
        self.bar.on_value_change(self._on_move)
        on_submit(self.field, self._on_type)
        desk.add_watcher(self._on_change)
        self._update_range()
        self._fill_field()

    def _update_range(self) -> None:
        c = self.control
        low, high = c.low / c.factor, c.high / c.factor
        self.bar.set_range(low, high, (high - low) / c.steps, c.digits)

    def _fill_field(self) -> None:
        c, value = self.control, read_number(self.desk, self.page, self.control)
        self._filling = True
        self.bar.set_value(min(max(value, c.low), c.high) / c.factor)
        self.field.set_value(f"{value / c.factor:.6g}")
        self._show_refusal("")
        self._filling = False

    def _show_refusal(self, problem: str, nearest_value: float | None = None) -> None:
        """Show an error below the field, with a button that sets the nearest allowed value."""
        # pressing that button blurs the field; a new button would miss the release
        if self._refusal == (problem, nearest_value):
            return
        self._refusal = (problem, nearest_value)
        self.field.error = problem or None
        if self._remedy is not None:
            self._remedy.delete()
            self._remedy = None
        if nearest_value is None:
            return
        with self._box:
            text = f"Use {show(nearest_value, self.control.spec.unit, 6)}"
            ident = f"{self.field.props['data-testid']}-remedy"
            act = partial(self._put_value, nearest_value)
            self._remedy = button(text, act, ident).classes("self-end")

    def _put_value(self, value: float) -> None:
        self.desk.put_setting(self.page, self.control.key, value)
        self._fill_field()

    def _on_move(self, event: Any) -> None:
        if self._filling:
            return
        self._show_refusal("")
        value = self.control.round_to_step(float(event.value) * self.control.factor)
        self.desk.put_setting(self.page, self.control.key, value)

    def _on_type(self) -> None:
        text = add_unit(str(self.field.value or ""), self.control.display_unit)
        try:
            value = self.control.spec.read(text, self.control.name)
        except QuantityError as err:
            self._show_refusal(str(err), self.control.nearest_value(text))
            return
        # leaving a field unchanged is not an undo step
        if value != read_number(self.desk, self.page, self.control):
            self._put_value(value)
        self._fill_field()

    def _on_change(self, change: str) -> None:
        if change == "page":
            # shared values may have been changed on a different page
            if self.page == self.desk.state.page and shared_setting(self.page, self.control.key):
                self._fill_field()
            return
        if change not in ("undo", "brake", "line", "moved"):
            return
        if change != "moved" and self._renew is not None:
            self.control = self._renew()
            self._update_range()
        self._fill_field()


def number_field(label: str, width: str) -> Field:
    """Return a right-aligned field for a number."""
    props = "dense outlined hide-bottom-space"
    return dress(Field(), "", width, props, aria_label=label, input_class="text-right")


def on_submit(field: ui.input, act: Callable[[], None]) -> None:
    """Call `act` when the user leaves a field or presses Enter in it."""
    field.on("keydown.enter", act)
    field.on("blur", act)


def add_unit(text: str, unit: str) -> str:
    """Return typed text with a unit; a bare number gets the page's unit."""
    text = text.strip()
    try:
        float(text)
    except ValueError:
        return text
    return f"{text} {unit}".strip()


def add_choice(desk: Desk, page: str, item: Choice) -> None:
    """Show the options as a row of buttons."""
    with ui.row().classes("w-full items-center justify-between"):
        ui.label(item.name).classes("text-sm").tooltip(page_text(item.help or item.name))
        toggle = ui.toggle(dict(item.words), value=read_word(desk, page, item))
        props = "dense no-caps unelevated"
        dress(toggle, f"{page}-{item.key}", "toggle", props, role="group", aria_label=item.name)
    _bind_box(desk, page, item, toggle)


def add_tabs(desk: Desk, page: str, item: Choice) -> None:
    """Show the parts of a page as tabs below its heading."""
    toggle = ui.toggle(dict(item.words), value=read_word(desk, page, item))
    props = "dense no-caps flat"
    dress(toggle, f"{page}-{item.key}", "page-tabs", props, role="group", aria_label=item.help)
    _bind_box(desk, page, item, toggle)


def add_menu(desk: Desk, page: str, item: Choice) -> None:
    """Show the options as a drop-down list, if they do not fit in a row."""
    ident, selected_word = f"{page}-{item.key}", read_word(desk, page, item)
    _bind_box(
        desk, page, item, select(item.words, item.name, ident, value=selected_word, tip=item.help)
    )


def _bind_box(desk: Desk, page: str, item: Choice, box: ui.toggle | ui.select) -> None:
    """Store the option selected in a box, and update the box after an undo."""

    def fill_box(change: str) -> None:
        if change == "undo" and box.value != read_word(desk, page, item):
            box.set_value(read_word(desk, page, item))

    box.on_value_change(lambda event: desk.put_setting(page, item.key, str(event.value)))
    desk.add_watcher(fill_box)
