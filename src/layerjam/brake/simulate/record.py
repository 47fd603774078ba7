"""Results as arrays with units, a named outcome, and all inputs needed to repeat the simulation."""

import io
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from layerjam._version import __version__
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.brief import brief
from layerjam.core.errors import FileError, MissingExtraError, Notice
from layerjam.core.store import accept_force_option, store_file
from layerjam.core.toml_files.table_text import comment, restore_comment
from layerjam.core.units import QuantitySpec

if TYPE_CHECKING:
    import pandas
    import xarray


class Outcome(StrEnum):
    """Outcome of a simulation."""

    FINISHED = "FINISHED"
    SEPARATED = "SEPARATED"
    CLOSED_BY_SLEEVE = "CLOSED_BY_SLEEVE"
    SNAPS = "SNAPS"
    STOPPED = "STOPPED"
    NEVER_SLID = "NEVER_SLID"
    BOTTOMED_OUT = "BOTTOMED_OUT"
    STEADY_SLIDING = "STEADY_SLIDING"
    JUDDERS = "JUDDERS"
    STUCK = "STUCK"


def column(unit: str, text: str) -> Any:
    """Return a field that contains one array, shape (N,)."""
    return field(repr=False, metadata={"quantity": QuantitySpec(unit, text)})


@dataclass(frozen=True, kw_only=True)
class Record:
    """Base of every result; its columns are the fields declared with `column`."""

    command: ClassVar[str] = ""
    outcome: Outcome
    brake: BrakeFile
    warnings: tuple[Notice, ...] = ()

    def conditions(self) -> dict[str, str]:
        """Return the other inputs needed to repeat the simulation."""
        return {}

    def columns(self) -> Iterator[tuple[str, np.ndarray, QuantitySpec]]:
        """Yield (name, array, QuantitySpec) of every column."""
        for f in fields(self):
            if "quantity" in f.metadata:
                yield f.name, getattr(self, f.name), f.metadata["quantity"]

    def to_frame(self) -> "pandas.DataFrame":
        """Return a data frame, one column per quantity in SI; units in `frame.attrs["units"]`."""
        import pandas

        frame = pandas.DataFrame({name: values for name, values, _ in self.columns()})
        frame.attrs["units"] = {name: m.unit for name, _, m in self.columns()}
        frame.attrs["outcome"] = str(self.outcome)
        return frame

    def to_xarray(self) -> "xarray.Dataset":
        """Return a Dataset along `time`, with units, meanings and all inputs to repeat it."""
        with MissingExtraError.raise_if_missing("a labelled result (xarray)", "labelled"):
            import xarray
        time = next(values for name, values, _ in self.columns() if name == "time")
        coordinate = ("sample", time, {"units": "s"})
        data = {
            name: ("sample", values, {"units": m.unit, "long_name": m.text})
            for name, values, m in self.columns()
            if name != "time"
        }
        return xarray.Dataset(data, coords={"time": coordinate}, attrs=self.header())

    def header(self) -> dict[str, str]:
        """Return the header above the columns."""
        return {
            "made_by": f"layerjam {__version__} {self.command}",
            "data": "synthetic: computed from a model, not measured",
            **self.conditions(),
            "outcome": str(self.outcome),
            "warnings": " | ".join(self.warnings),
            "brake": self.brake.render(self.brake.name),
        }

    @accept_force_option
    def to_csv(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write CSV: '#' header with the procedure and the whole brake, then columns with units."""
        head = self.header()
        lines = [comment(head.pop("made_by"))]
        brake = head.pop("brake")
        lines += [comment(f"{key}: {value}") for key, value in head.items()]
        lines += ["# brake:"] + [comment(f"  {line}") for line in brake.splitlines()]
        lines.append(",".join(f"{name} [{m.unit}]" for name, _, m in self.columns()))
        text = io.StringIO()
        text.write("\n".join(lines) + "\n")
        table = np.column_stack([values for _, values, _ in self.columns()])
        # repr gives the shortest digits that read back to the same number
        text.writelines(",".join(map(repr, row)) + "\n" for row in table.tolist())
        return store_file(path, text.getvalue(), overwrite)

    @accept_force_option
    def to_netcdf(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write NetCDF 3 through xarray and scipy."""
        dataset = self.to_xarray()
        return store_file(path, lambda p: dataset.to_netcdf(p, engine="scipy"), overwrite)

    @accept_force_option
    def save(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write .csv or .nc, depending on the path's extension; raises FileError for any other."""
        suffix = Path(path).suffix.lower()
        if suffix == ".csv":
            return self.to_csv(path, overwrite=overwrite)
        if suffix == ".nc":
            return self.to_netcdf(path, overwrite=overwrite)
        raise FileError(path, f"extension '{suffix}' is unknown; use .csv or .nc")


def header_values(record: Record, **units: str) -> dict[str, str]:
    """Return the numbers of a record with their units, as in the record's header."""
    return {
        name.replace("_", " "): f"{getattr(record, name)!r} {unit}" for name, unit in units.items()
    }


@dataclass(frozen=True, kw_only=True)
class PullRecord(Record):
    """Columns of every pull of a crosshead; arrays have shape (N,), SI units."""

    time: np.ndarray = column("s", "time since the start")
    elongation: np.ndarray = column("m", "crosshead elongation")
    force: np.ndarray = column("N", "force at the crosshead")
    slip: np.ndarray = column("m", "slip of the sheets")


@brief
@dataclass(frozen=True, kw_only=True)
class TensileRecord(PullRecord):
    """Simulated pull; arrays have shape (N,), SI units.

    `outcome` is the reason for its end; `brake`, `procedure` (as text) and `model` allow a repeat.
    """

    command: ClassVar[str] = "tensile"
    sleeve_force: np.ndarray = column("N", "force the enclosure carries while sliding")
    vacuum: np.ndarray = column("Pa", "vacuum inside the enclosure")
    work: np.ndarray = column("J", "work done on the brake")
    dissipated_energy: np.ndarray = column("J", "energy turned into heat")
    stored_energy: np.ndarray = column("J", "elastic energy of enclosure, sheets and mount")
    procedure: str
    model: str = "lumped"
    engine: str = "law"
    """Solver: "kernel" (C) or "law" (`brake_cycle`), which agree to 1.8e-9 N; not in files."""

    def conditions(self) -> dict[str, str]:
        """Return model and procedure."""
        return {"model": self.model, "procedure": self.procedure}


@brief
@dataclass(frozen=True, kw_only=True)
class DropRecord(Record):
    """Simulated stop of a mass; arrays have shape (N,), SI units; the rope is taut at time zero.

    `mass`, `speed` (on arrival), `vacuum` (at the taut rope), `rope_stiffness` (None without a
    rope), `rope_damping` and `gravity` (along the pull) allow it to be repeated. The
    `vacuum_in_time` column contains a changing vacuum. `step` [s] is that of the solver in time,
    None for the exact solver.
    """

    command: ClassVar[str] = "drop"
    time: np.ndarray = column("s", "time since the rope became taut")
    displacement: np.ndarray = column("m", "displacement of the mass since the rope became taut")
    speed_of_mass: np.ndarray = column("m/s", "speed of the mass")
    force: np.ndarray = column("N", "force on the mass")
    slip: np.ndarray = column("m", "slip of the sheets")
    vacuum_in_time: np.ndarray = column("Pa", "vacuum inside the enclosure")
    dissipated_energy: np.ndarray = column("J", "energy turned into heat in brake and rope")
    mass: float
    speed: float
    vacuum: float
    rope_stiffness: float | None
    rope_damping: float = 0.0
    gravity: float
    step: float | None = None

    @property
    def travel(self) -> np.ndarray:
        """Former name of `displacement`."""
        return self.displacement

    @property
    def deceleration(self) -> np.ndarray:
        """Return the deceleration [m/s^2]: force divided by mass, minus gravity along the pull."""
        return self.force / self.mass - self.gravity

    def conditions(self) -> dict[str, str]:
        """Return mass, speed, vacuum, rope, gravity and solver in SI."""
        rope = "none" if self.rope_stiffness is None else f"{self.rope_stiffness!r} N/m"
        changes = bool((self.vacuum_in_time != self.vacuum).any())
        solver = "exact" if self.step is None else f"in time, steps of {self.step!r} s"
        return {
            **header_values(self, mass="kg", speed="m/s"),
            "vacuum": "as in the column" if changes else f"{self.vacuum!r} Pa",
            "rope stiffness": rope,
            **header_values(self, rope_damping="N s/m"),
            "gravity along the pull": f"{self.gravity!r} m/s^2",
            "solver": solver,
        }


def read_header(path: str | Path) -> tuple[BrakeFile, str]:
    """Return (brake, procedure text) from the header of a CSV that `to_csv` wrote."""
    brake_lines: list[str] = []
    procedure, in_brake = "", False
    try:
        with Path(path).open(encoding="utf-8") as handle:
            for line in handle:
                if not line.startswith("#"):
                    break
                text = restore_comment(line)
                if in_brake:
                    brake_lines.append(text[4:])
                elif text.startswith("# procedure: "):
                    procedure = text.removeprefix("# procedure: ").strip()
                in_brake = in_brake or text.strip() == "# brake:"
    except (OSError, UnicodeDecodeError) as err:
        raise FileError(path, f"cannot be read: {err}") from None
    if not (procedure and brake_lines):
        raise FileError(path, "has no header with a brake and a procedure")
    return BrakeFile.read("".join(brake_lines), path), procedure
