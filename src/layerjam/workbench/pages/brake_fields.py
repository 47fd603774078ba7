"""The numbers of a brake as fields to type in, grouped as in its file, each with its source."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from nicegui import ui

from layerjam.commands.edit import BRAKE_FIELDS as FIELDS
from layerjam.errors import LayerjamError
from layerjam.records.source import KINDS
from layerjam.units import QuantitySpec, exact_text, get
from layerjam.workbench.desk import Desk

GROUPS: Mapping[str, str] = {
    "sheets": "Sheets", "film": "Film", "enclosure": "Sleeve", "mount": "Caps",
    "": "Whole brake", "rope": "Rope of the drop test", "site": "Site",
}  # fmt: skip
"""Table of the brake's file and what stands above its fields."""
NEW_KINDS = ("measured", "data sheet", "handbook", "assumed")
"""Kinds a number typed here may be of; the others are the files' own."""


def fields_of(group: str) -> list[str]:
    """The dotted paths of one table, in the file's order."""
    return [path for path in FIELDS if path.rpartition(".")[0] == group]


def typed_text(text: str, shown: str, spec: QuantitySpec) -> str | None:
    """What was typed as the verb takes it: a bare number is in the unit shown; None if empty."""
    text = text.strip()
    if not text:
        return None
    try:
        float(text)
    except ValueError:
        return text
    unit = shown.split(" ", 1)[1] if " " in shown else ""
    return f"{text} {unit}".strip() if spec.unit != "1" else text


class FieldRow:
    """One number: name, value with unit, where it comes from."""

    def __init__(self, desk: Desk, path: str, change: Callable[[str, str | None], str]) -> None:
        """`change(path, text)` gives why a value was refused, empty where it was taken."""
        self.desk, self.path, self.change = desk, path, change
        self.spec, self.required = FIELDS[path]
        name = path.rpartition(".")[2].replace("_", " ")
        with ui.column().classes("w-full gap-0"):
            with ui.row().classes("w-full items-center justify-between no-wrap gap-2"):
                ui.label(name.capitalize()).classes("text-sm").tooltip(self.help())
                self.field = ui.input().props(
                    f'dense outlined hide-bottom-space input-class="text-right" '
                    f'aria-label="{name}, {self.spec.text}" data-testid="brake-{path}" '
                    f'placeholder="{"" if self.required else "not known"}"'
                ).classes("w-40")  # fmt: skip
            self.kind = ui.label().classes("text-xs opacity-80 source-line").props(
                f'data-testid="brake-{path}-source"'
            )  # fmt: skip
        self.field.on("keydown.enter", self.typed)
        self.field.on("blur", self.typed)
        self.fill()

    def help(self) -> str:
        """QuantitySpec, symbol and bounds."""
        symbol = f" {self.spec.symbol}:" if self.spec.symbol else ""
        return f"{self.path}:{symbol} {self.spec.text}; {self.spec.allowed()}"

    def shown(self) -> str:
        """The value as it stands in the field; empty for what is not known."""
        value = get(self.desk.brake.brake, self.path)
        if value is None:
            return ""
        return f"{value:g}" if self.spec.whole else exact_text(value, self.spec.unit)

    def fill(self) -> None:
        """Value and source of the brake on the desk."""
        self.field.set_value(self.shown())
        self.field.error = None
        source = self.desk.brake.sources.get(self.path)
        default = "the default" if self.shown() else ""
        said = default if source is None else source.sentence()
        self.kind.set_text(said)
        self.kind.set_visibility(bool(said))

    def typed(self) -> None:
        """Take what was typed, or say below why not."""
        text = str(self.field.value or "").strip()
        if text == self.shown():
            self.field.error = None
            return
        why = self.change(self.path, typed_text(text, self.shown(), self.spec))
        if why:
            self.field.error = why
        else:
            self.fill()


class Fields:
    """All numbers of the brake, one fold for each table of its file."""

    def __init__(
        self, desk: Desk, change: Callable[[str, str | None], str], open_groups: tuple[str, ...]
    ) -> None:
        self.rows: list[FieldRow] = []
        self._desk, self._change = desk, change
        for group, title in GROUPS.items():
            fold = (
                ui.expansion(title, value=group in open_groups)
                .classes("w-full")
                .props(f'dense header-class="font-medium" data-testid="brake-group-{group}"')
            )
            if fold.value:
                self._fill(fold, group)
            else:  # a fold nobody opens costs the first page its time
                fold.on_value_change(partial(self._fill, fold, group))
        desk.watch(self._changed)

    def _fill(self, fold: ui.expansion, group: str, _: object = None) -> None:
        """Once, the fields into their fold."""
        if not fold.default_slot.children:
            with fold:
                self.rows += [FieldRow(self._desk, path, self._change) for path in fields_of(group)]

    def _changed(self, what: str) -> None:
        if what in ("brake", "undo"):
            for row in self.rows:
                row.fill()


def origin(desk: Desk, page: str) -> tuple[str, str]:
    """Kind and source that go with numbers typed from now on."""
    kind = str(desk.get(page, "kind", "assumed"))
    return kind if kind in NEW_KINDS else "assumed", str(desk.get(page, "source", ""))[:200]


def origin_fields(desk: Desk, page: str) -> None:
    """Where new numbers come from, asked once for all that are typed next."""
    kind, source = origin(desk, page)
    with ui.expansion("Where new numbers come from").classes("w-full").props("dense"):
        chosen = ui.select(
            {k: f"{k}: {KINDS[k]}" for k in NEW_KINDS}, value=kind, label="Kind",
            on_change=lambda e: desk.put(page, "kind", str(e.value)),
        ).props('dense outlined data-testid="brake-kind"').classes("w-full")  # fmt: skip
        words = ui.input(
            "Source", value=source, placeholder="caliper, 3 places",
            on_change=lambda e: desk.put(page, "source", str(e.value or "")),
        ).props('dense outlined maxlength=200 data-testid="brake-source"').classes(
            "w-full"
        )  # fmt: skip

    def fill(what: str) -> None:
        if what == "undo":
            now = origin(desk, page)
            chosen.set_value(now[0])
            words.set_value(now[1])

    desk.watch(fill)


def refusal(error: LayerjamError) -> str:
    """An error as one line for below a field."""
    return " ".join(str(error).split())
