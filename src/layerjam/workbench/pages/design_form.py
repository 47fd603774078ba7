"""The usual need in a few numbers; what it writes goes into the specification and is searched."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from layerjam.design.few_numbers import HOLD, STOP, hold, stop
from layerjam.device.load import catalogue
from layerjam.errors import LayerjamError
from layerjam.workbench.controls import Choice, Control, choice, number, slider, word
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.design_part import PAGE

KIND = Choice("form", {"hold": "hold a force", "stop": "stop a mass"}, "hold", label="Need")
HOLDS = (
    Control("hold_force", HOLD["force"], 300.0, 10.0, 3000.0, unit="N", label="Holding force"),
    Control("hold_mass", HOLD["mass"], 0.06, 0.01, 0.5, unit="g", label="Mass at most"),
    Control("hold_width", HOLD["width"], 0.025, 0.005, 0.1, unit="mm", label="Width at most"),
    Control("hold_length", HOLD["length"], 0.11, 0.06, 0.4, unit="mm", label="Length at most"),
    Control("hold_margin", HOLD["stress_margin"], 2.0, 0.0, 5.0, label="Safety on stress"),
)
STOPS = (
    Control("stop_mass", STOP["mass"], 75.0, 0.5, 150.0, unit="kg", label="Mass"),
    Control("stop_speed", STOP["speed"], 2.0, 0.1, 10.0, unit="m/s", label="Speed"),
    Control("stop_travel", STOP["travel"], 0.3, 0.01, 1.0, unit="mm", label="Travel at most"),
    Control("stop_force", STOP["force"], 4000.0, 50.0, 10_000.0, unit="N",
            label="Force at most"),
    Control("stop_margin", STOP["stress_margin"], 1.5, 0.0, 5.0, label="Safety on stress"),
)  # fmt: skip


class Form:
    """Sliders that write a specification from the desk's brake."""

    def __init__(self, desk: Desk, written: Callable[[str], None]) -> None:
        """`written` takes the TOML text."""
        self.desk, self.written = desk, written

    def build(self) -> None:
        """Closed at first, as the text is there already."""
        with (
            ui.expansion("Write it from a few numbers")
            .classes("w-full")
            .props(f'dense header-class="font-medium" data-testid="{PAGE}-form-open"')
        ):
            choice(self.desk, PAGE, KIND)
            self.boxes = {}
            for key, controls in (("hold", HOLDS), ("stop", STOPS)):
                with ui.column().classes("w-full gap-2") as self.boxes[key]:
                    for control in controls:
                        slider(self.desk, PAGE, control)
            self.refused = (
                ui.label("")
                .classes("text-negative text-sm")
                .props(f'role="alert" data-testid="{PAGE}-form-problem"')
            )
            ui.button("Write and search", icon="edit_note", on_click=self.write).props(
                f'no-caps dense outline data-testid="{PAGE}-write"'
            )
            ui.label("It begins from the brake on the desk and its film.").classes(
                "text-sm opacity-80"
            )
        self.desk.watch(lambda _: self._show())
        self._show()

    def _show(self) -> None:
        for key, box in self.boxes.items():
            box.set_visibility(key == word(self.desk, PAGE, KIND))

    def text(self) -> str:
        """The specification of the numbers of now; raises LayerjamError."""
        file = self.desk.brake
        own = self.desk.state.brake not in catalogue()
        called = f"{file.name}.toml" if own else self.desk.state.brake
        kind = word(self.desk, PAGE, KIND)
        controls = HOLDS if kind == "hold" else STOPS
        *asked, margin = [(c, number(self.desk, PAGE, c)) for c in controls]
        said = {c.key.split("_", 1)[1]: c.text(value) for c, value in asked}
        made = hold if kind == "hold" else stop
        return made(file, called, **said, stress_margin=margin[1]).text()

    def write(self) -> None:
        """Into the editor, and search."""
        try:
            text = self.text()
        except LayerjamError as err:
            self.refused.set_text(" ".join(str(err).split()))
            return
        self.refused.set_text("")
        self.written(text)
