"""Page elements with a name for tests, a label and a common style."""

import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from html import escape
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from nicegui import events, ui

from layerjam.core.errors import LayerjamError
from layerjam.core.units import show
from layerjam.workbench import live
from layerjam.workbench.certainty import basis_html, interval_meaning, interval_text
from layerjam.workbench.spoken import format_sentence, typeset_text

E = TypeVar("E", bound=ui.element)
Act = Callable[[], Any]
PLAIN = 'outline dense no-caps padding="4px 10px"'
QUIET = "text-sm opacity-80"


def dress(element: E, ident: str = "", classes: str = "", look: str = "", **more: Any) -> E:
    """Set an element's name for tests, classes, flags (`look`) and other attributes; return it.

    Underscores in attribute names become dashes, as in `aria_label`.
    """
    if ident:
        more["data-testid"] = ident
    if look:
        element.props(look)
    for name, value in more.items():
        text = typeset_text(value) if name == "aria_label" and isinstance(value, str) else value
        element.props[name.replace("_", "-")] = text
    return element.classes(classes) if classes else element


def key_title(key: str) -> str:
    """Return the page's name for a key of a result."""
    words = key.replace("_", " ").split()
    words = [word.upper() if word in ("mape", "rmse", "sd") else word for word in words]
    return " ".join([words[0][0].upper() + words[0][1:], *words[1:]])


def hint(text: str) -> ui.label:
    """Show a sentence in small grey type."""
    return ui.label(typeset_text(text)).classes(QUIET)


def status(ident: str, classes: str = "", text: str = "") -> live.Words:
    """Show a sentence that changes as a slider moves and that screen readers announce."""
    return dress(live.Words(text), ident, classes, role="status")


def heading(text: str, level: int = 2, ident: str = "") -> ui.label:
    """Create the heading of a page (level 1) or of a part of it."""
    element = dress(ui.label(text), ident, f"heading heading-{level}")
    element.tag = f"h{level}"
    return element


def find_error(act: Callable[..., object], *args: Any) -> str:
    """Do an action and return its error as one line, or an empty text."""
    try:
        act(*args)
    except LayerjamError as error:
        return one_line(error)
    return ""


class Alert(ui.label):
    """Line that shows why an input was rejected, hidden if there is no error."""

    def __init__(self, ident: str, classes: str = "") -> None:
        super().__init__("")
        dress(self, ident, f"text-negative {classes}", role="alert")
        self.set_visibility(False)

    def show_error(self, problem: str) -> None:
        """Show an error, or hide the line if it is empty."""
        self.set_text(typeset_text(problem))
        self.set_visibility(bool(problem))


def button(
    text: str, act: Act | None, ident: str, icon: str = "", *, look: str = PLAIN, tip: str = ""
) -> ui.button:
    """Return a button; `tip` is a longer explanation."""
    element = dress(ui.button(text, icon=icon or None, on_click=act), ident, look=look)
    return element.tooltip(typeset_text(tip)) if tip else element


def fold(title: str, ident: str = "", is_open: bool = False) -> ui.expansion:
    """Return a panel that a click opens and closes."""
    element = ui.expansion(title, value=is_open)
    return dress(element, ident, "w-full", "dense", header_class="font-medium")


def chart(ident: str, label: str, style: str = "", act: Any = None) -> ui.echart:
    """Return an empty chart that can be zoomed; `label` describes it for screen readers."""
    element = dress(ui.echart({}, on_point_click=act), ident, role="figure", aria_label=label)
    element.on("vnodeMounted", js_handler="(node) => layerjamPrepareChart(node)")
    return element.style(style) if style else element.classes("chart")


def select(
    words: Mapping[str, str],
    label: str,
    ident: str,
    act: Callable[[events.ValueChangeEventArguments[Any]], Any] | None = None,
    *,
    value: str | None = None,
    classes: str = "w-full",
    tip: str = "",
) -> ui.select:
    """Return a drop-down list; `words` maps each stored value to its displayed text."""
    element = ui.select(dict(words), value=value, label=label, on_change=act)
    dress(element, ident, classes, "dense outlined options-dense", aria_label=label)
    return element.tooltip(typeset_text(tip)) if tip else element


def field(
    label: str,
    ident: str,
    value: str = "",
    *,
    tip: str = "",
    example: str = "",
    classes: str = "w-full",
    longest: int = 300,
) -> ui.input:
    """Return a text field, which displays `example` while it is empty."""
    element = ui.input(label, value=value, placeholder=example)
    look = "dense outlined hide-bottom-space stack-label"
    dress(element, ident, classes, look, aria_label=label, maxlength=longest)
    return element.tooltip(typeset_text(tip)) if tip else element


ZONE = """<div class="zone-head"><span>{label}</span><q-btn flat dense round icon="add_box"
 aria-label="{label}, or choose files" @click="props.pickFiles"></q-btn>
<span style="display: none"><q-uploader-add-trigger></q-uploader-add-trigger></span></div>"""
"""Replaces Quasar's header, whose file field and button have no accessible names."""


def drop_area(area: ui.upload, label: str, ident: str, classes: str = "w-full") -> ui.upload:
    """Return an area for dropped files, with a button to choose files; `label` is its text."""
    area.add_slot("header", ZONE.format(label=label))
    return dress(area, ident, classes, "flat bordered", role="group", aria_label=label)


def columns(classes: str = "", all_shown: bool = False) -> tuple[ui.column, ui.column]:
    """Lay out controls on the left and results on the right.

    On a narrow screen, they are stacked: the first two controls, a button that shows the others,
    and the results. With `all_shown`, all controls are visible from the start.
    """
    with ui.row().classes(f"w-full no-wrap items-start gap-6 page {classes}") as row:
        side = ui.column().classes("side")
        if not all_shown:
            row.classes("page-folds")
            show_all = button("All controls", None, "", "tune")
            show_all.on("click", js_handler="(event) => layerjamFold(event.currentTarget)")
            dress(show_all, "", "side-more", aria_expanded="false", aria_controls=side.html_id)
        return side, ui.column().classes("main gap-3")


@cache
def read_asset(name: str) -> str:
    """Return the text of a file in this folder."""
    return (Path(__file__).parent / name).read_text(encoding="utf-8")


def one_line(error: object) -> str:
    """Return an error as one line, in the page's terms."""
    return format_sentence(error)


class Hero(NamedTuple):
    """A large number: its key on the page, its name, its value with unit, and its interval."""

    key: str
    name: str
    text: str
    interval: str = ""
    meaning: str = ""
    """Sentence on what the interval contains."""


def predicted_hero(ident: str, name: str, result: Any, key: str) -> Hero:
    """Return the large number `key` of a result, with its 95 % interval if there is one."""
    value, unit = getattr(result, key), result.units[key]
    interval = interval_text(result, key, unit, value)
    return Hero(ident, name, show(value, unit), interval, interval_meaning(result, key))


_NUMBER = re.compile(r"\d+\.?\d*")


def round_value(text: str) -> str:
    """Round the number in a text to three significant digits: 59.9 kPa for 59.93 kPa."""

    def round_number(number: re.Match[str]) -> str:
        value = float(number[0])
        return f"{value:.0f}" if value >= 100 else f"{value:.3g}"

    return _NUMBER.sub(round_number, text, count=1)


class Heroes:
    """Large numbers that change as a slider moves; tests find each by page and key."""

    def __init__(self, page: str) -> None:
        self._page = page
        self._table = dress(live.Table(), f"{page}-heroes", "w-full")

    def fill(self, numbers: Sequence[Hero], source: Any = None, subject: str = "") -> None:
        """Show the numbers in the given order, and what those of the result `source` rest on.

        The `subject` names these numbers, unless all numbers are from `source`.
        """
        basis = basis_html(source, f"{self._page}-basis", subject) if numbers else ""
        self._table.set_content(headline_html(self._page, numbers) + basis)


def headline_html(page: str, numbers: Sequence[Hero]) -> str:
    """Return large numbers as HTML: three digits, all digits on hover, and a smaller unit.

    An interval is a smaller line below its number.
    """
    cells = []
    for key, name, text, interval, meaning in numbers:
        value, _, unit = round_value(text).rpartition(" ") if " " in text else (text, "", "")
        unit_html = f" <small>{escape(unit)}</small>" if unit else ""
        ident = escape(f"{page}-{key}")
        cell = f'<dd data-testid="{ident}" title="{escape(text)}">{escape(value)}{unit_html}</dd>'
        if interval:
            tip = f' title="{escape(meaning)}"' if meaning else ""
            interval_attributes = f'data-testid="{ident}-interval"{tip}'
            cell += f'<dd class="interval" {interval_attributes}>{escape(interval)}</dd>'
        cells.append(f"<div><dt>{escape(name)}</dt>{cell}</div>")
    return f'<dl class="heroes">{"".join(cells)}</dl>'
