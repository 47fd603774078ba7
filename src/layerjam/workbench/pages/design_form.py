"""Form for a requirement, kept consistent with its TOML text."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from nicegui import ui

from layerjam.brake.device.load import catalogue
from layerjam.core.errors import LayerjamError
from layerjam.workbench.controls import Choice, Control, add_choice, map_keys
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import ControlGroup
from layerjam.workbench.pages.design_part import PAGE
from layerjam.workbench.widgets import Alert, dress, find_error, heading, hint, one_line, read_asset
from layerjam.workshop.design.few_numbers import FORCES, HOLD, PREFERENCES, STOP, hold, stop
from layerjam.workshop.design.request import DesignRequest, Range, open_reader, read_request

KIND = Choice("form", {"hold": "hold a force", "stop": "stop a mass"}, "hold", label="It must")
FORCE_MOMENT = Choice(
    "when",
    {"rest": "at rest", "sliding": "while sliding"},
    "rest",
    label="Resist the force",
    help="At rest: before the sheets slip. While sliding: the peak of a pull, which is lower",
)
PREFER = Choice(
    "prefer",
    {"mass": "lowest mass", "length": "shortest", "energy": "highest energy"},
    "mass",
    label="Prefer",
    help="Choice among the brakes that meet the requirement",
)
MAKERS: Mapping[str, Callable[..., DesignRequest]] = {"hold": hold, "stop": stop}


def _make_control(
    kind: str, name: str, default: float, span: tuple[float, float], label: str, **more: Any
) -> Control:
    spec = (HOLD if kind == "hold" else STOP)[name]
    key = "margin" if name == "stress_margin" else name
    return Control(f"{kind}_{key}", spec, default, *span, label=label, **more)


ASKED = {
    "hold": (
        _make_control("hold", "force", 150.0, (10.0, 1000.0), "Force", unit="N"),
        _make_control("hold", "travel", 0.03, (0.0, 0.1), "Travel", unit="mm"),
    ),
    "stop": (
        _make_control("stop", "mass", 75.0, (0.5, 150.0), "Mass to stop", unit="kg"),
        _make_control("stop", "speed", 2.0, (0.1, 10.0), "Speed"),
        _make_control("stop", "travel", 0.3, (0.01, 1.0), "Maximum travel", unit="mm"),
        _make_control("stop", "force", 4000.0, (50.0, 10_000.0), "Maximum force", unit="N"),
    ),
}
"""{kind of requirement: controls of its duty}."""
LIMITS = {
    "hold": (
        _make_control("hold", "vacuum", 94e3, (20e3, 101e3), "Available vacuum"),
        _make_control("hold", "mass", 0.025, (0.005, 0.2), "Maximum mass as drawn", unit="g"),
        _make_control("hold", "width", 0.025, (0.005, 0.1), "Maximum width", unit="mm"),
        _make_control("hold", "length", 0.215, (0.12, 0.47), "Maximum length", unit="mm"),
        _make_control("hold", "stress_margin", 2.0, (0.0, 5.0), "Stress safety factor"),
    ),
    "stop": (
        _make_control("stop", "vacuum", 94e3, (20e3, 101e3), "Available vacuum"),
        _make_control("stop", "own_mass", 20.0, (0.01, 20.0), "Maximum mass as drawn", unit="kg"),
        _make_control("stop", "width", 0.04, (0.005, 0.1), "Maximum width", unit="mm"),
        _make_control("stop", "length", 2.0, (0.1, 5.0), "Maximum length", unit="mm"),
        _make_control("stop", "stress_margin", 1.5, (0.0, 5.0), "Stress safety factor"),
    ),
}
"""{kind of requirement: controls of its limits}."""


class Form(ControlGroup):
    """Sliders that specify a requirement for the desk's brake; `take` receives its TOML text."""

    name = PAGE

    def __init__(self, desk: Desk, take: Callable[[str], None]) -> None:
        super().__init__(desk)
        self.take, self.text_written = take, ""
        self._follows = False
        """Whether the form is being set from typed text."""

    def controls(self) -> Mapping[str, Control]:
        """Return the controls of both kinds of requirement."""
        groups = (*ASKED.values(), *LIMITS.values())
        return map_keys(*(control for group in groups for control in group))

    def build(self) -> None:
        """Build the controls for duty, limits and preference."""
        add_choice(self.desk, PAGE, KIND)
        for kind in MAKERS:
            with self.show_while(lambda kind=kind: self.word(KIND) == kind):  # type: ignore[misc]
                self._build_sliders(ASKED[kind][:1])
                if kind == "hold":
                    add_choice(self.desk, PAGE, FORCE_MOMENT)
                    drawing = ui.html(read_asset("pages/force_moment.html"), sanitize=False)
                    dress(drawing, classes="figure", role="img", aria_label=FORCE_MOMENT.help)
                self._build_sliders(ASKED[kind][1:])
                heading("Limits")
                self._build_sliders(LIMITS[kind])
        add_choice(self.desk, PAGE, PREFER)
        self.refused = Alert(f"{PAGE}-form-problem", "text-sm")
        hint("The search starts from the current brake and its film.")
        self.desk.add_watcher(lambda change: self.submit_text() if change != "page" else None)
        with suppress(LayerjamError):
            self.text_written = self.current_text()

    def _build_sliders(self, controls: tuple[Control, ...]) -> None:
        for control in controls:
            self.add_slider(control.key)

    def current_text(self) -> str:
        """Return the requirement as TOML text; raises LayerjamError if it is invalid."""
        file, kind = self.desk.brake, self.word(KIND)
        is_own = self.desk.state.brake not in catalogue()
        file_name = f"{file.name}.toml" if is_own else self.desk.state.brake
        *inputs, margin = (*ASKED[kind], *LIMITS[kind])
        texts = {c.key.split("_", 1)[1]: self.text(c.key) for c in inputs}
        moment = {"when": self.word(FORCE_MOMENT)} if kind == "hold" else {}
        request = MAKERS[kind](
            *(file, file_name),
            **texts,
            **moment,
            stress_margin=self.value(margin.key),
            prefer=self.word(PREFER),
        )
        return str(request.text())

    def submit_text(self) -> None:
        """Pass the text to `take` if it has changed."""
        try:
            text = self.current_text()
        except LayerjamError as err:
            self.refused.show_error(one_line(err))
            return
        self.refused.show_error("")
        if text != self.text_written:
            self.text_written = text
            if not self._follows:
                self.take(text)

    def follow_text(self, text: str) -> None:
        """Set the numbers that a typed text contains; the form ignores its other content."""
        try:
            request = read_request(open_reader(text, "requirement"))
        except LayerjamError:
            return
        specs = {c.key: c.spec for c in self.controls().values()}
        values = form_settings(request)
        usable = {
            k: v
            for k, v in values.items()
            if k not in specs or not find_error(specs[k].check, v, "value")
        }
        self._follows = True
        self.desk.put_settings(PAGE, usable)
        self._follows = False


def form_settings(request: DesignRequest) -> dict[str, Any]:
    """Return the form's settings for a requirement."""
    kind = "stop" if request.stop is not None else "hold"
    values: dict[str, Any] = {"form": kind}
    keys = {"mass": "mass" if kind == "hold" else "own_mass", "stress_margin": "margin"}
    keys |= {"width": "width", "length": "length", "usable_travel": "travel"}
    for limit in request.constraints:
        for moment, name in FORCES.items():
            if kind == "hold" and limit.name == name:
                values |= {"when": moment, "hold_force": limit.limit}
        if limit.name in keys and (kind == "hold" or limit.name != "usable_travel"):
            values[f"{kind}_{keys[limit.name]}"] = limit.limit
    if request.stop is not None:
        of_stop = ("mass", "speed", "travel", "force")
        values |= {f"stop_{name}": getattr(request.stop, name) for name in of_stop}
    vacuums = request.vary.get("vacuum")
    if vacuums:
        highest = vacuums.last if isinstance(vacuums, Range) else max(vacuums)
        values[f"{kind}_vacuum"] = highest
    first = request.objectives[0]
    for word, objective in PREFERENCES.items():
        if (first.name, first.least) == (objective.name, objective.least):
            values["prefer"] = word
    return values
