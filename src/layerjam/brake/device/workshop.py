"""Data for making a brake: the [build] table, and notes on film and silicone.

These data do not affect a brake's behaviour; their records are separate from Brake and are never
traced.
"""

from dataclasses import dataclass
from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.mount import Mount
from layerjam.core.errors import QuantityError
from layerjam.core.toml_files.values import AsItIs, ListSpec, TextSpec, value
from layerjam.core.units import (
    QuantitySpec,
    exact_text,
    get_spec,
    like,
    nested,
    quantity,
    record,
    show,
)

CUTTERS = ("service", "laser", "knife")
LASER = ("never", "with care", "yes")
TUBE = QuantitySpec("m", "outer diameter of the tube", lo=1e-3, hi=0.02)
SIDE = QuantitySpec("m", "side", lo=1e-3, hi=100)
GAUGE = QuantitySpec("m", "available thickness of the film", lo=1e-6, hi=0.01)
PRODUCT = TextSpec(text="name of the product in a shop", blank=False)
M5 = "M5"
M5_BORE = 4.2e-3
"""Diameter of the hole into which an M5 thread is cut [m]; M5 has a minor diameter of 4.134 mm."""
GLUED = 0.1e-3
"""Diametral clearance between the bore and a tube that is glued in [m]."""
PORT_WALL = 2e-3
"""Thickness of the wall around the port [m]."""
LEAST_SCREW_HOLE = 2e-3
"""Diameter of the smallest screw that is drawn, M2 [m]."""


@dataclass(frozen=True)
class PortSpec(AsItIs):
    """The air port: the thread M5, or the outer diameter of a tube that is glued in."""

    text: str = "air port: 'M5', or the outer diameter of a tube that is glued in"

    def limits(self) -> str:
        """Return both choices as a phrase."""
        return f"M5, or a tube's diameter {TUBE.limits()}"

    def read(self, text: object, name: str) -> str | float:
        """Return the word `M5`, or a diameter [m]."""
        if isinstance(text, str) and text.strip().upper() == M5:
            return M5
        try:
            return float(TUBE.read(text, name))
        except QuantityError:
            value_text = f"'{text}'" if isinstance(text, str) else f"{text}"
            raise QuantityError.of(
                name, f"{value_text[:60]} is not a port; use M5 or a tube's diameter such as '4 mm'"
            ) from None

    def check(self, value: Any, name: str) -> Any:
        """Return `value` if it is the word `M5` or an allowed diameter."""
        return value if value == M5 else TUBE.check(value, name)

    def to_toml(self, value: Any) -> object:
        """Return the word `M5`, or text with a unit."""
        return value if isinstance(value, str) else exact_text(float(value), "m")


@dataclass(frozen=True)
class SizeSpec(AsItIs):
    """A size with two or three sides, such as "600 mm x 400 mm" or "145x145x175mm"."""

    text: str
    sides: int

    def limits(self) -> str:
        """Return the number of sides and an example."""
        return f"{self.sides} lengths such as '{self.example}', each {SIDE.limits()}"

    @property
    def example(self) -> str:
        """Text that a user could type."""
        return " x ".join(f"{side} mm" for side in (600, 400, 300)[: self.sides])

    def read(self, text: object, name: str) -> tuple[float, ...]:
        """Return the sides [m]; the unit of the last one applies to sides without a unit."""
        if not isinstance(text, str):
            raise QuantityError.of(name, f"must be text such as '{self.example}'")
        parts = [part.strip() for part in text.lower().replace("×", "x").split("x")]
        if len(parts) != self.sides or not all(parts):
            raise QuantityError.of(
                name, f"'{text[:60]}' does not have {self.sides} lengths; write '{self.example}'"
            )
        unit = parts[-1].lstrip("+-0123456789.e ")
        texts = [p if p[-1].isalpha() or p[-1] == '"' else f"{p} {unit}".strip() for p in parts]
        return tuple(float(SIDE.read(part, name)) for part in texts)

    def check(self, value: Any, name: str) -> Any:
        """Return `value` if it has the right number of sides, all within bounds."""
        if len(value) != self.sides:
            raise QuantityError.of(name, f"needs {self.sides} lengths, such as '{self.example}'")
        for side in value:
            SIDE.check(side, name)
        return value

    def to_toml(self, value: Any) -> object:
        """Return text with units."""
        return " x ".join(exact_text(float(side), "m") for side in value)


def _length_field(text: str, default: float | None, lo: float = 0.0, hi: float = 0.1) -> Any:
    return quantity("m", text, lo=lo, hi=hi, default=default)


@record
class Build:
    """[build]: choices of the builder; a missing value has its default."""

    cutter: str = value(TextSpec(text="how the film is cut", choices=CUTTERS), "service")
    kerf: float = _length_field("full width of the cut", 0.0, hi=1e-3)
    stock_length: float | None = _length_field("length of the film stock", None, 1e-3, 100)
    stock_width: float | None = _length_field("width of the film stock", None, 1e-3, 100)
    margin: float = _length_field("width kept free along the stock's edges", 5e-3)
    gap: float = _length_field("distance between two parts on the film", 3e-3)
    tip_radius: float = _length_field("radius of a sheet's corners at its free end", 1e-3)
    clamp_radius: float = _length_field("radius of a sheet's corners at its clamped end", 0.5e-3)
    screws: int | None = like(
        get_spec(Mount, "screws"),
        ("screws in each cap; must equal the number in [mount]"),
        default=None,
    )
    floor: float = _length_field("minimum printed floor under a nut or head", 1.2e-3, 0.4e-3, 0.01)
    wall: float = _length_field("minimum printed wall", 1.2e-3, 0.4e-3, 0.01)
    cheek: float = _length_field("thickness of the tray's sides", 1.6e-3, 0.4e-3, 0.02)
    side: float = _length_field("gap between a sheet and the tray's side", 0.3e-3, 0.0, 5e-3)
    fit: float = _length_field("clearance of nut and clamp plate", 0.2e-3, 0.0, 2e-3)
    head_room: float = _length_field("recess depth of screw heads and ends", 0.2e-3, hi=5e-3)
    plenum: float = _length_field("depth of the air space behind the sheets", 1e-3, 0.1e-3, 0.05)
    back: float = _length_field("thickness of the tray's back wall", 3e-3, 0.4e-3, 0.05)
    air_bore: float = _length_field("diameter of the air bore", 2e-3, 0.3e-3, 0.02)
    neck_length: float = _length_field("length of the round neck that the tie closes", 8e-3, 1e-3)
    neck_stretch: float = quantity(
        "1", "stretch of the enclosure around the neck", open_lo=True, hi=9.0, default=0.25
    )
    tie_width: float = _length_field("width of the cable tie", 2.5e-3, 1e-3, 0.02)
    tie_slot: float = _length_field("width of the groove for the tie", 3.5e-3, 1e-3, 0.03)
    tie_depth: float = _length_field("depth of the groove for the tie", 0.6e-3, 0.0, 0.01)
    tie_strength: float = quantity("N", "strength of the cable tie", lo=1.0, hi=1e4, default=80.0)
    tie_tension: float = quantity(
        "N", "force to which the cable tie is pulled", open_lo=True, hi=1e4, default=25.0
    )
    port: str | float = value(PortSpec(), M5)
    pin: float = _length_field("diameter of the dowel pin", 6e-3, 1e-3, 0.05)
    pin_clearance: float = _length_field("diametral clearance of the dowel pin", 0.1e-3, hi=2e-3)
    pin_wall: float = _length_field("wall thickness around the dowel pin", 3e-3, 0.4e-3, 0.05)
    edge: float = _length_field("radius of the cap's long edges", 1e-3, hi=0.02)
    sleeve_clearance: float = _length_field("gap between stack and enclosure", 0.0, hi=2e-3)
    shrinkage: float = quantity("1", "shrinkage of the silicone", hi=0.02, default=0.0)
    trim: float = _length_field("length trimmed off each end of the casting", 5e-3)
    mould_wall: float = _length_field("wall thickness of the mould", 5e-3, 0.4e-3)
    core_print: float = _length_field("length over which the mould holds the core", 10e-3, 1e-3)
    core_clearance: float = _length_field("gap around the core where it is held", 0.1e-3, hi=2e-3)
    mould_bolt: float = _length_field(
        "diameter of the hole for the mould's bolts; 4.5 mm for M4", 4.5e-3, 1e-3, 0.02
    )
    sprue: float = _length_field("diameter of the sprue", 4e-3, 0.5e-3, 0.02)
    vent: float = _length_field("diameter of a vent", 1.5e-3, 0.3e-3, 0.02)
    key: float = _length_field("diameter and height of the mould's keys", 4e-3, 1e-3, 0.02)
    key_clearance: float = _length_field("diametral clearance of the keys", 0.3e-3, hi=2e-3)
    waste: float = quantity(
        "1", "silicone lost in cup and nozzle, relative to that in the mould", hi=5.0, default=0.3
    )
    print_density: float = quantity(
        "kg/m^3", "density of the printed plastic", lo=100, hi=25000, default=1150.0
    )
    print_modulus: float = quantity(
        "Pa", "modulus of the printed plastic", lo=1e6, hi=1e12, default=2.5e9
    )
    print_strength: float | None = quantity(
        "Pa", "strength of the printed plastic", lo=1e5, hi=1e11, default=None
    )
    nut_factor: float = quantity(
        "1", "nut factor: torque / (preload × screw diameter)", lo=0.1, hi=0.4, default=0.2
    )
    laser_bed: tuple[float, float] | None = value(SizeSpec("size of the laser bed", 2), None)
    print_bed: tuple[float, float, float] | None = value(
        SizeSpec(("build volume of the printer"), 3), None
    )

    @property
    def port_bore(self) -> float:
        """Diameter of the port's bore [m]."""
        return M5_BORE if self.port == M5 else float(self.port) + GLUED

    @property
    def port_length(self) -> float:
        """Length of the port with its walls, along the pull [m]."""
        return self.port_bore + 2 * PORT_WALL

    @property
    def head(self) -> float:
        """Length of the head that holds the pin [m]."""
        return self.pin + 2 * self.pin_wall

    @property
    def fittings_length(self) -> float:
        """Length of a brake beyond the clamped ends of its sheets, at both ends together [m]."""
        return 2 * (self.plenum + self.back + self.neck_length + self.port_length + self.head)


@record
class FilmCutting:
    """Data for buying and cutting a film, in addition to the values in [film]."""

    product: str | None = value(PRODUCT, None)
    gauges: tuple[float, ...] | None = value(ListSpec(each=GAUGE), None)
    laser: str | None = value(
        TextSpec(text="whether the film may be cut by a CO2 laser", choices=LASER), None
    )


@record
class Casting:
    """Data for buying and casting a silicone, in addition to the values in [enclosure]."""

    product: str | None = value(PRODUCT, None)
    mix: str | None = value(TextSpec(text="mixing ratio, such as '1A:1B'"), None)
    viscosity: float | None = quantity(
        "Pa s", "viscosity of the mixed silicone", lo=1e-3, hi=1e5, default=None
    )
    pot_life: float | None = quantity(
        "s", "pot life of the mixed silicone", lo=1, hi=1e6, default=None
    )
    cure_time: float | None = quantity("s", "cure time of the silicone", lo=1, hi=1e7, default=None)
    elongation_at_break: float | None = quantity(
        "1", "elongation at break of the silicone", lo=0.01, hi=50, default=None
    )


@record
class Making:
    """All data about making a brake that its file may contain."""

    build: Build = nested(Build, default=Build())
    film: FilmCutting = nested(FilmCutting, default=FilmCutting())
    enclosure: Casting = nested(Casting, default=Casting())


def find_changed_input(build: Build, *names: str) -> str:
    """Return the first input that is not at its default, otherwise the first one.

    If inputs contradict each other, the error should name one that the user has set.
    """
    default = Build()
    return next((n for n in names if getattr(build, n) != getattr(default, n)), names[0])


def check_build(brake: Brake, build: Build) -> None:
    """Raise QuantityError if choices contradict each other or the values of the brake."""
    hole, width = brake.mount.screw_hole, brake.sheets.width

    def refuse(key: str, problem: str, unit: str = "m") -> None:
        raise QuantityError.of(f"build.{key}", f"{show(getattr(build, key), unit)} {problem}")

    def check_order(small: str, large: str, may_be_equal: bool, unit: str = "m") -> None:
        """Raise an error unless `small` is below `large` or, with `may_be_equal`, equal to it."""
        low, high = getattr(build, small), getattr(build, large)
        if low < high or (may_be_equal and low == high):
            return
        key = find_changed_input(build, small, large)
        words = (
            ("is more than", "is less than")
            if may_be_equal
            else ("is not less than", "is not more than")
        )
        problem, limit = (words[0], large) if key == small else (words[1], small)
        refuse(key, f"{problem} build.{limit}, {show(getattr(build, limit), unit)}", unit)

    screws = int(brake.mount.count_screws(width))
    if build.screws not in (None, screws):
        detail = f"it states {screws}"
        if brake.mount.screws is None:
            detail = (
                f"it states none, and the default for sheets {show(width, 'm')} wide is {screws}"
            )
        raise QuantityError.of(
            "build.screws",
            f"{build.screws} contradicts [mount], which takes precedence: {detail}; write "
            f"screws = {build.screws} in [mount]",
        )
    if build.kerf and build.cutter == "knife":
        refuse("kerf", "must be 0 for a knife, because the plotter applies its own offset")
    if build.kerf and build.kerf >= hole:
        refuse("kerf", f"must be less than the screw's hole of {show(hole, 'm')}")
    if build.kerf:
        check_order("kerf", "gap", may_be_equal=False)
    check_order("kerf", "margin", may_be_equal=True)
    for radius in ("tip_radius", "clamp_radius"):
        if getattr(build, radius) >= width / 2:
            refuse(radius, f"must be less than half the sheets' width, {show(width / 2, 'm')}")
    if build.cutter == "knife":
        for radius in ("tip_radius", "clamp_radius"):
            if getattr(build, radius) < 0.5e-3:
                refuse(radius, "is too sharp for a knife; give at least 0.5 mm")
    check_order("edge", "cheek", may_be_equal=False)
    check_order(
        "sprue", "trim", may_be_equal=True
    )  # the entire sprue is in the part that is trimmed off
    check_order("vent", "trim", may_be_equal=True)
    check_order("tie_width", "tie_slot", may_be_equal=True)
    check_order("tie_slot", "neck_length", may_be_equal=False)
    check_order("tie_tension", "tie_strength", may_be_equal=True, unit="N")
    for key, pair in (("stock_length", "stock_width"), ("stock_width", "stock_length")):
        if getattr(build, key) is not None and getattr(build, pair) is None:
            refuse(key, f"is given without build.{pair}; give both or neither")
