"""The specification of a design in TOML: what may be varied, what must hold, what is wanted.

Every quantity carries its unit; every error names the file and, where it can, the line.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.design.grid import AXES, Array, Asked, Grid
from layerjam.design.merit import (
    LINE_MERITS,
    STOP_MERITS,
    VARIABLES,
    Judder,
    Stock,
    line_table,
    point_of,
    stock_of,
)
from layerjam.design.stopping import Need
from layerjam.design.wishes import EVERY, Constraint, Objective, Scatter, Spec
from layerjam.device.file import BrakeFile
from layerjam.device.load import catalogue, load, materials
from layerjam.device.mount import Site
from layerjam.device.sheets import Film
from layerjam.errors import FileError, LayerjamError, QuantityError, UnknownNameError
from layerjam.fluid.file import LineFile, lines, load_line
from layerjam.records.shipped import shipped, text_of
from layerjam.records.toml import line_of, parse_toml
from layerjam.units import QuantitySpec, show, spec_of

MOST_VALUES = 1_000_000
MOST_DESIGNS = 10**12
NEED = {
    "mass": QuantitySpec("kg", "mass to stop", lo=1e-3, hi=1e6),
    "speed": QuantitySpec("m/s", "speed of the mass", lo=1e-3, hi=1000),
    "travel": QuantitySpec("m", "slip it may take", lo=1e-4, hi=100),
    "force": QuantitySpec("N", "greatest force allowed", open_lo=True, hi=1e9),
}
_JUDDER = {
    "speed": QuantitySpec("m/s", "speed of the pull", lo=1e-7, hi=100),
    "mass": QuantitySpec("kg", "mass pulled", lo=1e-6, hi=1e6),
    "damping_ratio": QuantitySpec("1", "damping of the mount over the critical one", hi=10),
}
_SD = QuantitySpec("1", "standard deviation of the friction, relative", hi=1)
_SAMPLES = QuantitySpec("1", "samples of the friction", lo=100, hi=10_000_000, whole=True)
_SEED = QuantitySpec("1", "seed", hi=2**63 - 1, whole=True)
_WEIGHT = QuantitySpec("1", "weight of an objective", open_lo=True, hi=1e6)
_TOP = {"name", "title", "brake", "line", "atmosphere", "constraints", "objectives", "weights"}
_TABLES = {"vary", "film", "stop", "judder", "scatter"}


def examples() -> dict[str, str]:
    """{name: TOML text} of the specifications that come with the program."""
    return shipped("layerjam.design", "examples")


def load_spec(spec: str | Path) -> Spec:
    """A specification by the name of an example or the path of its file.

    Raises FileError, or UnknownNameError with the nearest names.
    """
    return read_spec(*text_of("specification", spec, examples()))


def read_spec(
    text: str, path: object, beside: Mapping[str, BrakeFile | LineFile] | None = None
) -> Spec:
    """A specification from TOML text; raises FileError with file and line.

    With `beside` no file is opened: what the text names is one of these, or in the catalogue.
    """
    return _Parser(text, path, beside).spec()


class _Parser:
    def __init__(
        self, text: str, path: object, beside: Mapping[str, BrakeFile | LineFile] | None
    ) -> None:
        self.text, self.path, self.beside = text, path, beside
        self.tables: dict[str, Any] = parse_toml(text, path)
        self.notes: list[str] = []

    def fail(self, key: str, reason: str) -> FileError:
        line = line_of(self.text, key)
        if line is None:
            hits = (i for i, row in enumerate(self.text.splitlines(), 1) if key and key in row)
            line = next(hits, None)
        return FileError(self.path, reason, line)

    def spec(self) -> Spec:
        for key in self.tables:
            if key not in _TOP | _TABLES:
                raise self.fail(key, str(UnknownNameError("key", key, _TOP | _TABLES)))
        name = self.tables.get("name", Path(str(self.path)).stem)
        if not isinstance(name, str):
            raise self.fail("name", "name must be a text in quotes")
        brake, line = self.brake(), self.line()
        if line is not None and "atmosphere" in self.tables:
            site = replace(line.line.site, atmosphere=brake.brake.site.atmosphere)
            line = replace(line, line=replace(line.line, site=site))
        need, judder = self.need(brake), self.judder()
        grid = self.grid(brake)
        rise = work = None
        if line is not None:
            if line.line.site.atmosphere != brake.brake.site.atmosphere:
                raise self.fail("line", f"atmosphere: not the same in {line.name} and {brake.name}")
            rise, work = line_table(grid.axes["vacuum"], line.line)
        asked = Asked(brake.brake, judder, need, rise, work)
        known = {*asked.all_names, *VARIABLES}
        constraints = self.constraints(known) + _of_need(need)
        objectives = self.objectives({*asked.all_names})
        return Spec(
            name=name, brake=brake, line=line,
            grid=grid, asked=asked, constraints=constraints, objectives=objectives,
            scatter=self.scatter(brake), text=self.text, notes=tuple(self.notes),
        )  # fmt: skip

    def brake(self) -> BrakeFile:
        given = self.tables.get("brake")
        if not isinstance(given, str):
            raise self.fail("brake", "brake is missing: the brake to start from, name or path")
        file = self.named("brake", given, load)
        if "atmosphere" in self.tables:
            pressure = self.read("atmosphere", self.tables["atmosphere"],
                                 spec_of(Site, "atmosphere"))  # fmt: skip
            site = replace(file.brake.site, atmosphere=pressure)
            file = replace(file, brake=replace(file.brake, site=site))
        return file

    def line(self) -> LineFile | None:
        given = self.tables.get("line")
        if given is None:
            return None
        if not isinstance(given, str):
            raise self.fail("line", "line must be a name or path in quotes")
        file = self.named("line", given, load_line)
        rough = file.line.tube is not None or file.line.leak.orifice or file.line.polytropic != 1
        if rough or file.line.chamber.shrink:
            self.notes.append(
                f"rise_time on {file.name} by the closed form of a rigid chamber at one "
                "temperature: its tube, orifice leak and shrinking are left out"
            )
        return file

    def named(self, key: str, name: str, reader: Any) -> Any:
        """A file by catalogue name, or by a path from the specification's folder."""
        if self.beside is not None:
            if name in self.beside:
                return self.beside[name]
            known = catalogue() if reader is load else lines()
            if name not in known:
                raise self.fail(name, str(UnknownNameError(key, name, [*self.beside, *known])))
            return reader(name)
        near = Path(str(self.path)).parent / name
        try:
            return reader(near if name.endswith(".toml") and near.is_file() else name)
        except UnknownNameError as err:
            raise self.fail(key, str(err)) from None

    def read(self, key: str, value: object, spec: QuantitySpec) -> float:
        try:
            return float(spec.read(value, key))
        except LayerjamError as err:
            raise self.fail(key, str(err)) from None

    def table(self, name: str, keys: Mapping[str, Any]) -> dict[str, Any] | None:
        given = self.tables.get(name)
        if given is None:
            return None
        if not isinstance(given, dict):
            raise self.fail(name, f"{name} must be a table, [{name}]")
        for key in given:
            if key not in keys:
                raise self.fail(
                    f"{name}.{key}", str(UnknownNameError(f"key of [{name}]", key, keys))
                )
        return given

    def need(self, brake: BrakeFile) -> Need | None:
        given = self.table("stop", [*NEED, "horizontal"])  # type: ignore[arg-type]
        if given is None:
            return None
        got: dict[str, Any] = {
            k: self.read(f"stop.{k}", given[k], m) if k in given else None for k, m in NEED.items()
        }
        for due in ("mass", "speed"):
            if got[due] is None:
                raise self.fail("stop", f"stop.{due} is missing: {NEED[due].text}")
        flat = given.get("horizontal", False)
        if not isinstance(flat, bool):
            raise self.fail("stop.horizontal", "stop.horizontal must be true or false")
        return Need(**got, gravity=0.0 if flat else brake.brake.site.gravity)

    def judder(self) -> Judder | None:
        given = self.table("judder", _JUDDER)
        if given is None:
            return None
        for key, spec in _JUDDER.items():
            if key not in given:
                raise self.fail("judder", f"judder.{key} is missing: {spec.text}")
        return Judder(**{k: self.read(f"judder.{k}", given[k], m) for k, m in _JUDDER.items()})

    def scatter(self, brake: BrakeFile) -> Scatter | None:
        given = self.table("scatter", ["static", "kinetic", "samples", "seed"]) or {}  # type: ignore[arg-type]
        found = {n: spread_of(brake, f"film.{n}") for n in ("static", "kinetic")}
        sd = {
            n: self.read(f"scatter.{n}", given[n], _SD) if n in given else found[n] for n in found
        }
        if sd["static"] is None and sd["kinetic"] is None:
            return None
        more = {
            n: int(self.read(f"scatter.{n}", given[n], m))
            for n, m in (("samples", _SAMPLES), ("seed", _SEED))
            if n in given
        }
        source = "the specification" if {"static", "kinetic"} & set(given) else (
            f"the spread that {brake.name} states for its friction"
        )  # fmt: skip
        return Scatter(sd["static"] or 0.0, sd["kinetic"] or 0.0, source, **more)

    # ---- what is varied

    def grid(self, brake: BrakeFile) -> Grid:
        vary = self.table("vary", VARIABLES) or {}
        start = point_of(brake.brake)
        axes: dict[str, Array] = {}
        ranges: dict[str, tuple[float, float]] = {}
        for name in AXES:
            if name in vary:
                axes[name] = self.axis(name, vary[name], ranges)
            elif name != "usable_travel":
                axes[name] = np.array([float(getattr(start, name))])
        thickness = self.axis("thickness", vary["thickness"], {}) if "thickness" in vary else None
        stock, names, thick = self.stocks(brake, thickness)
        grid = Grid(stock, names, thick, axes, ranges)
        if grid.size > MOST_DESIGNS:
            raise self.fail("vary", f"{grid.size:.3g} designs are too many; {MOST_DESIGNS:.0e} go")
        high, most = float(axes["vacuum"].max()), brake.brake.site.atmosphere
        if high > most * (1 + 1e-12):
            raise self.fail("vary.vacuum", f"vary.vacuum: {show(high, 'Pa', 6)} is more than the "
                            f"atmosphere, {show(most, 'Pa', 6)}")  # fmt: skip
        return grid

    def axis(self, name: str, given: object, ranges: dict[str, tuple[float, float]]) -> Array:
        """The values of one variable: one, a list, or from, to and step."""
        key, spec = f"vary.{name}", VARIABLES[name]
        if isinstance(given, list):
            if not given or len(given) > MOST_VALUES:
                raise self.fail(key, f"{key}: a list of values is not empty")
            values = np.array([self.read(key, v, spec) for v in given])
            if len(np.unique(values)) != len(values):
                raise self.fail(key, f"{key}: a value stands twice")
            return np.sort(values)
        if not isinstance(given, dict):
            return np.array([self.read(key, given, spec)])
        if set(given) != {"from", "to", "step"}:
            raise self.fail(key, f"{key}: a range holds from, to and step; nothing else")
        low, high = (self.read(key, given[word], spec) for word in ("from", "to"))
        step = self.read(key, given["step"], QuantitySpec(spec.unit, "step", open_lo=True))
        if high < low:
            raise self.fail(key, f"{key}: from {show(low, spec.unit)} to "
                            f"{show(high, spec.unit)} is empty; from is the lesser")  # fmt: skip
        if spec.whole and step != int(step):
            raise self.fail(key, f"{key}: the step {step} is not allowed; it is a whole number")
        steps = math.floor((high - low) / step * (1 + 1e-12) + 1e-9)
        if steps >= MOST_VALUES:
            raise self.fail(key, f"{key}: more than {MOST_VALUES} values")
        if not spec.whole and high > low:
            ranges[name] = (low, high)
        values = low + step * np.arange(steps + 1)
        # ten digits undo the rounding of sums of steps, so that 13 mm is 13 mm
        return np.array([float(f"{v:.12g}") for v in values])

    def stocks(
        self, brake: BrakeFile, thickness: Array | None
    ) -> tuple[Stock, tuple[str, ...], Array]:
        """Films, each with the thicknesses it is sold in."""
        given = self.tables.get("film")
        films: list[tuple[str, Stock, Array]] = []
        base = np.array([float(brake.brake.sheets.thickness)])
        if given is None:
            films.append(
                (brake.name, stock_of(brake.brake), base if thickness is None else thickness)
            )
        elif not isinstance(given, list) or not all(isinstance(f, dict) for f in given):
            raise self.fail("film", "film must be tables, [[film]], one for each film")
        for entry in given or []:
            odd = set(entry) - {"use", "thickness"}
            use = entry.get("use")
            if odd or not isinstance(use, str):
                raise self.fail("film", "a [[film]] holds use (a brake or a film of the catalogue) "
                                "and thickness, a list")  # fmt: skip
            own = self.thicknesses(use, entry.get("thickness"))
            rows = own if own is not None else thickness if thickness is not None else base
            films.append((use, self.film(use, brake), rows))
        names = tuple(n for n, _, rows in films for _ in rows)
        if len(set(names)) < len({(n, i) for i, (n, _, _) in enumerate(films)}):
            raise self.fail("film", "a film stands twice")
        thick = np.concatenate([rows for _, _, rows in films])
        columns = zip(*(s for _, s, rows in films for _ in rows), strict=True)
        return Stock(*(np.array(c, float) for c in columns)), names, thick

    def thicknesses(self, use: str, given: object) -> Array | None:
        if given is None:
            return None
        rows = given if isinstance(given, list) else [given]
        spec = VARIABLES["thickness"]
        try:
            return np.array([spec.read(v, f"thickness of {use}") for v in rows], float)
        except LayerjamError as err:
            raise self.fail(use, str(err)) from None

    def film(self, use: str, brake: BrakeFile) -> Stock:
        """Film by brake (its friction and scale factor) or by name in the catalogue (a = 1)."""
        films = materials()["films"]
        if use in catalogue() or use.endswith(".toml"):
            other = self.named(use, use, load).brake
            if other.pressure_exponent != brake.brake.pressure_exponent:
                raise self.fail(use, f"{use} has another pressure_exponent than {brake.name}; "
                                "films are compared under one law")  # fmt: skip
            return stock_of(other)
        if use not in films:
            raise self.fail(use, str(UnknownNameError("film", use, [*films, *catalogue()])))
        table = {k: v for k, v in parse_toml(films[use], use).items() if k not in ("name", "note")}
        got = {
            k: spec_of(Film, k).read(v["value"] if isinstance(v, dict) else v, k)
            for k, v in table.items()
            if k in Film.__dataclass_fields__
        }
        self.notes.append(
            f"{use}: handbook friction and a scale factor of 1, not measured on a brake"
        )
        missing = [n for n in ("modulus", "density", "static", "kinetic", "friction_on_silicone")
                   if n not in got]  # fmt: skip
        if missing:
            raise self.fail(use, f"{use} has no {', '.join(missing)}")
        return Stock(
            got["modulus"], got["density"], got["static"], got["kinetic"],
            got["friction_on_silicone"], got.get("strength", math.nan), 1.0,
        )  # fmt: skip

    # ---- what must hold and what is wanted

    def constraints(self, known: set[str]) -> tuple[Constraint, ...]:
        out = []
        for said in self.sentences("constraints"):
            match = re.fullmatch(r"\s*(\w+)\s*(<=|>=)\s*(.+?)\s*", said)
            if not match:
                raise self.fail(said, f"constraint '{said[:60]}' is not of the form "
                                "'mass <= 30 g' or 'holding_force >= 300 N'")  # fmt: skip
            name, sense, limit = match.groups()
            self.check_name(said, name, known, "constraint")
            unit = EVERY[name].unit
            spec = QuantitySpec(unit, f"limit of {name}", lo=-math.inf)
            try:
                value = spec.read(float(limit) if unit == "1" and _plain(limit) else limit, name)
            except QuantityError as err:
                raise self.fail(said, str(err)) from None
            out.append(Constraint(name, sense == "<=", float(value)))
        return tuple(out)

    def objectives(self, known: set[str]) -> tuple[Objective, ...]:
        sentences = self.sentences("objectives")
        if not sentences:
            raise self.fail("objectives", "objectives are missing, such as ['minimise mass']")
        weights = self.tables.get("weights", [1.0] * len(sentences))
        if not isinstance(weights, list) or len(weights) != len(sentences):
            raise self.fail("weights", f"weights must be a list of {len(sentences)} numbers")
        out = []
        for said, weight in zip(sentences, weights, strict=True):
            match = re.fullmatch(r"\s*(minimi[sz]e|maximi[sz]e)\s+(\w+)\s*", said)
            if not match:
                raise self.fail(said, f"objective '{said[:60]}' is not of the form 'minimise mass' "
                                "or 'maximise force_density'")  # fmt: skip
            self.check_name(said, match.group(2), known, "objective")
            share = self.read("weights", weight, _WEIGHT)
            out.append(Objective(match.group(2), match.group(1).startswith("min"), share))
        if len({o.name for o in out}) < len(out):
            raise self.fail("objectives", "objectives: a quantity stands twice")
        return tuple(out)

    def sentences(self, key: str) -> Sequence[str]:
        given = self.tables.get(key, [])
        if not isinstance(given, list) or not all(isinstance(s, str) for s in given):
            raise self.fail(key, f"{key} must be a list of texts in quotes")
        return given

    def check_name(self, said: str, name: str, known: set[str], kind: str) -> None:
        if name in known:
            return
        due = {**dict.fromkeys(LINE_MERITS, "a line"), **dict.fromkeys(STOP_MERITS, "a [stop]")}
        due["judder_margin"] = "a [judder]"
        if name in due:
            raise self.fail(said, f"{kind} '{said[:60]}' needs {due[name]} in the specification")
        raise self.fail(said, str(UnknownNameError(kind, name, known)))


def _plain(text: str) -> bool:
    return bool(re.fullmatch(r"[+-]?[\d.]+(e[+-]?\d+)?", text))


def _of_need(need: Need | None) -> tuple[Constraint, ...]:
    if need is None:
        return ()
    slip = () if need.travel is None else (Constraint("stop_slip", True, need.travel),)
    peak = () if need.force is None else (Constraint("stop_peak", True, need.force),)
    # a stop without limits must still be one
    return (*slip, *peak) or (Constraint("stop_slip", True, 1e9),)


def spread_of(file: BrakeFile, path: str) -> float | None:
    """The relative SD that a brake's file states for a number ("SD 8.18 %"), else None."""
    source = file.sources.get(path)
    match = re.search(r"\bSD\s+([\d.]+)\s*%", source.spread) if source else None
    return float(match.group(1)) / 100 if match else None
