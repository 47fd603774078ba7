"""A run for other programs: CSV with its sidecar, Parquet, NetCDF; each says what the run is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.device.load import write_whole
from layerjam.errors import FileError, MissingExtraError
from layerjam.measure.run_text import UNITS, csv_text, facts_of, in_order
from layerjam.measure.runs import Array, Run, read_run
from layerjam.measure.shots import MEASURED, SYNTHETIC, Shot
from layerjam.measure.sidecar import sidecar_path, write_facts

ENDINGS = (".csv", ".parquet", ".nc")
INT32 = 1 << 31


@dataclass(frozen=True, kw_only=True)
class ExportedRun:
    """What was written."""

    run: Run
    file: Path
    sidecar: Path | None
    shots: tuple[Path, ...] = ()
    """Files of the accelerometer's records; NetCDF has them inside."""


def export(
    run: str | Path,
    out: str | Path,
    *,
    start: float | None = None,
    end: float | None = None,
    force: bool = False,
) -> ExportedRun:
    """Write a run, or what of it lies from `start` to `end` [s], by the ending of `out`.

    The accelerometer's records go into files beside it, NAME-shot1.csv.

    Raises FileError for a file that is no run or cannot be written, QuantityError where no sample
    is left, MissingExtraError for Parquet without pyarrow.
    """
    out = Path(out)
    ending = out.suffix.lower()
    if ending not in ENDINGS:
        raise FileError(out, f"the ending '{out.suffix}' is not known; use {', '.join(ENDINGS)}")
    found = read_run(run)
    if start is not None or end is not None:
        found = found.between(start, end)
    beside_it = {} if ending == ".nc" else {shot_file(out, s): s for s in found.shots}
    if (there := next((path for path in beside_it if path.exists()), None)) and not force:
        raise FileError(there, "exists already; --force replaces it")
    sidecar = None
    if ending == ".csv":
        beside = sidecar_path(out)
        if beside.exists() and not force:
            raise FileError(beside, "exists already; --force replaces it")
        write_whole(out, csv_text(found), force)
        sidecar = write_facts(out, facts_of(found), force)
    elif ending == ".parquet":
        _table(in_order(found), said(found), out, force)
    else:
        _netcdf(found, out, force)
    for path, shot in beside_it.items():
        if ending == ".csv":
            write_whole(path, shot.text({"run_id": found.meta.get("run_id", "")}), force)
        else:
            columns = {"time": shot.time, "acceleration": shot.acceleration}
            _table(columns, {**said(found), **facts_of_shot(shot)}, path, force)
    return ExportedRun(run=found, file=out, sidecar=sidecar, shots=tuple(beside_it))


def shot_file(out: Path, shot: Shot) -> Path:
    """The file of an accelerometer's record, beside that of its run."""
    return out.with_name(f"{out.stem}-shot{shot.number}{out.suffix}")


def facts_of_shot(shot: Shot) -> dict[str, str]:
    """What is to be said of an accelerometer's record."""
    return {"shot": f"{shot.number}", "range": f"{shot.range:.6g} m/s^2", "rate": f"{shot.rate} Hz"}


def said(run: Run) -> Mapping[str, str]:
    """What the run says of itself, and whether it is synthetic."""
    data = SYNTHETIC if run.simulated else MEASURED
    return {"data": data, **{key: text for key, text in run.meta.items() if text}}


def _table(columns: Mapping[str, Array], stated: Mapping[str, str], out: Path, force: bool) -> None:
    """Parquet."""
    with MissingExtraError.raise_if_missing("Parquet (pyarrow)", "sweep"):
        import pyarrow as pa  # type: ignore[import-untyped]
        import pyarrow.parquet as parquet  # type: ignore[import-untyped]
    fields = []
    for name, values in columns.items():
        unit = {"unit": UNITS[name]} if name in UNITS else None
        fields.append(pa.field(name, pa.from_numpy_dtype(values.dtype), metadata=unit))
    table = pa.table(dict(columns), schema=pa.schema(fields, metadata=dict(stated)))
    write_whole(out, lambda path: parquet.write_table(table, path, compression="zstd"), force)


def _netcdf(run: Run, out: Path, force: bool) -> None:
    """NetCDF 3, which has no integers of 64 bits: numbers beyond 32 become doubles, exactly."""
    from scipy.io import netcdf_file

    def fill(path: Path) -> None:
        with netcdf_file(path, "w", version=2) as file:
            for key, text in said(run).items():
                setattr(file, key, text.encode())
            file.createDimension("sample", run.samples)
            for name, values in in_order(run).items():
                whole = values.dtype.kind == "i" and np.abs(values).max(initial=0) < INT32
                made = file.createVariable(name, "i4" if whole else "f8", ("sample",))
                made[:] = values
                if name in UNITS:
                    made.units = UNITS[name].encode()
            for shot in run.shots:
                _add_shot(file, shot)

    write_whole(out, fill, force)


def _add_shot(file: Any, shot: Shot) -> None:
    """An accelerometer's record in a NetCDF file, over a dimension of its own."""
    name = f"shot{shot.number}"
    file.createDimension(f"{name}_sample", len(shot.counts))
    for column in ("time", "acceleration"):
        made = file.createVariable(f"{name}_{column}", "f8", (f"{name}_sample",))
        made[:] = getattr(shot, column)
        made.units = UNITS[column].encode()
    for key, text in facts_of_shot(shot).items():
        setattr(made, key, text.encode())
