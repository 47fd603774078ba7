"""The usual requirement in a few numbers; what it writes is the specification."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from layerjam.design.few_numbers import HOLD, STOP, hold, stop
from layerjam.device.load import catalogue
from layerjam.errors import LayerjamError
from layerjam.workbench.controls import Choice, Control, by_key, choice
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import Asking
from layerjam.workbench.pages.design_part import PAGE
from layerjam.workbench.widgets import Alert, button, fold, hint, one_line

KIND = Choice("form", {"hold": "hold a force", "stop": "stop a mass"}, "hold", label="Requirement")
MAKERS: Mapping[str, Callable[..., Any]] = {"hold": hold, "stop": stop}


def _control(
    kind: str, name: str, default: float, span: tuple[float, float], **more: Any
) -> Control:
    spec = (HOLD if kind == "hold" else STOP)[name]
    key = "margin" if name == "stress_margin" else name
    return Control(f"{kind}_{key}", spec, default, *span, **more)


HOLDS = (
    _control("hold", "force", 300.0, (10.0, 3000.0), unit="N", label="Holding force"),
    _control("hold", "mass", 0.06, (0.01, 0.5), unit="g", label="Mass at most"),
    _control("hold", "width", 0.025, (0.005, 0.1), unit="mm", label="Width at most"),
    _control("hold", "length", 0.11, (0.06, 0.4), unit="mm", label="Length at most"),
    _control("hold", "stress_margin", 2.0, (0.0, 5.0), label="Safety on stress"),
)
STOPS = (
    _control("stop", "mass", 75.0, (0.5, 150.0), unit="kg", label="Mass"),
    _control("stop", "speed", 2.0, (0.1, 10.0), unit="m/s", label="Speed"),
    _control("stop", "travel", 0.3, (0.01, 1.0), unit="mm", label="Travel at most"),
    _control("stop", "force", 4000.0, (50.0, 10_000.0), unit="N", label="Force at most"),
    _control("stop", "stress_margin", 1.5, (0.0, 5.0), label="Safety on stress"),
)


class Form(Asking):
    """Sliders that write a specification from the desk's brake."""

    name = PAGE

    def __init__(self, desk: Desk, written: Callable[[str], None]) -> None:
        """`written` takes the TOML text."""
        super().__init__(desk)
        self.written = written

    def controls(self) -> Mapping[str, Control]:
        """Of both kinds of requirement."""
        return by_key(*HOLDS, *STOPS)

    def build(self) -> None:
        """Closed at first, as the text is there already."""
        with fold("Write it from a few numbers", f"{PAGE}-form-open"):
            choice(self.desk, PAGE, KIND)
            for kind, controls in (("hold", HOLDS), ("stop", STOPS)):
                with self.while_(lambda kind=kind: self.word(KIND) == kind):  # type: ignore[misc]
                    for control in controls:
                        self.slider(control.key)
            self.refused = Alert(f"{PAGE}-form-problem", "text-sm")
            look = "no-caps dense outline"
            button("Write and search", self.write, f"{PAGE}-write", "edit_note", how=look)
            hint("It begins from the brake on the desk and its film.")

    def specification(self) -> str:
        """The specification of the numbers of now; raises LayerjamError."""
        file, kind = self.desk.brake, self.word(KIND)
        own = self.desk.state.brake not in catalogue()
        called = f"{file.name}.toml" if own else self.desk.state.brake
        *asked, margin = HOLDS if kind == "hold" else STOPS
        said = {c.key.split("_", 1)[1]: self.text(c.key) for c in asked}
        made = MAKERS[kind](file, called, **said, stress_margin=self.value(margin.key))
        return str(made.text())

    def write(self) -> None:
        """Into the editor, and search."""
        try:
            text = self.specification()
        except LayerjamError as err:
            self.refused.say(one_line(err))
            return
        self.refused.say("")
        self.written(text)
