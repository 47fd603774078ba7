"""Export of a run as CSV with a sidecar file, Parquet or NetCDF, each with its metadata."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.core.errors import FileError, MissingExtraError
from layerjam.core.store import accept_force_option, store_file
from layerjam.laboratory.measure.run_text import (
    UNITS,
    format_run_csv,
    make_run_facts,
    order_columns,
)
from layerjam.laboratory.measure.runs import Array, Run, read_run
from layerjam.laboratory.measure.shots import MEASURED, SYNTHETIC, Shot
from layerjam.laboratory.measure.sidecar import sidecar_path, write_facts

ENDINGS = (".csv", ".parquet", ".nc")
INT32 = 1 << 31


@dataclass(frozen=True, kw_only=True)
class ExportedRun:
    """An exported run and the files that were written."""

    run: Run
    file: Path
    sidecar: Path | None
    shots: tuple[Path, ...] = ()
    """Files with the accelerometer's records; none for NetCDF, whose file contains them."""


@accept_force_option
def export(
    run: str | Path,
    out: str | Path,
    *,
    start: float | None = None,
    end: float | None = None,
    overwrite: bool = False,
) -> ExportedRun:
    """Write a run, or the part from `start` to `end` [s], in the format of `out`'s extension.

    The accelerometer's records are written to files next to it, NAME-shot1.csv.

    Raises FileError if `run` is not a run or `out` cannot be written, QuantityError if no sample is
    left, or MissingExtraError if pyarrow (for Parquet) is not installed.
    """
    out = Path(out)
    ending = out.suffix.lower()
    if ending not in ENDINGS:
        raise FileError(out, (f"extension '{out.suffix}' is unknown; use {', '.join(ENDINGS)}"))
    run_ = read_run(run)
    if start is not None or end is not None:
        run_ = run_.between(start, end)
    shot_files = {} if ending == ".nc" else {shot_path(out, s): s for s in run_.shots}
    sidecars = [*shot_files, sidecar_path(out)] if ending == ".csv" else shot_files
    if (existing := next((path for path in sidecars if path.exists()), None)) and not overwrite:
        raise FileError(existing, "already exists; --overwrite replaces it")
    sidecar = None
    if ending == ".csv":
        store_file(out, format_run_csv(run_), overwrite)
        sidecar = write_facts(out, make_run_facts(run_), overwrite)
    elif ending == ".parquet":
        _write_table(order_columns(run_), describe_run(run_), out, overwrite)
    else:
        _write_netcdf(run_, out, overwrite)
    for path, shot in shot_files.items():
        if ending == ".csv":
            store_file(path, shot.text({"run_id": run_.meta.get("run_id", "")}), overwrite)
        else:
            columns = {"time": shot.time, "acceleration": shot.acceleration}
            _write_table(columns, {**describe_run(run_), **shot_metadata(shot)}, path, overwrite)
    return ExportedRun(run=run_, file=out, sidecar=sidecar, shots=tuple(shot_files))


def shot_path(out: Path, shot: Shot) -> Path:
    """Return the file of an accelerometer's record, next to that of its run."""
    return out.with_name(f"{out.stem}-shot{shot.number}{out.suffix}")


def shot_metadata(shot: Shot) -> dict[str, str]:
    """Return the metadata of an accelerometer's record."""
    return {"shot": f"{shot.number}", "range": f"{shot.range:.6g} m/s^2", "rate": f"{shot.rate} Hz"}


def describe_run(run: Run) -> Mapping[str, str]:
    """Return the metadata of a run, and whether it is synthetic."""
    data = SYNTHETIC if run.simulated else MEASURED
    return {"data": data, **{key: text for key, text in run.meta.items() if text}}


def _write_table(
    columns: Mapping[str, Array], facts: Mapping[str, str], out: Path, overwrite: bool
) -> None:
    with MissingExtraError.raise_if_missing("Parquet (pyarrow)", "sweep"):
        import pyarrow as pa  # type: ignore[import-untyped]
        import pyarrow.parquet as parquet  # type: ignore[import-untyped]
    fields = []
    for name, values in columns.items():
        unit = {"unit": UNITS[name]} if name in UNITS else None
        fields.append(pa.field(name, pa.from_numpy_dtype(values.dtype), metadata=unit))
    table = pa.table(dict(columns), schema=pa.schema(fields, metadata=dict(facts)))
    store_file(out, lambda path: parquet.write_table(table, path, compression="zstd"), overwrite)


def _write_netcdf(run: Run, out: Path, overwrite: bool) -> None:
    """Write NetCDF 3; it has no 64-bit integers, so long ones are stored as exact doubles."""
    from scipy.io import netcdf_file

    def write_file(path: Path) -> None:
        with netcdf_file(path, "w", version=2) as file:
            for key, text in describe_run(run).items():
                setattr(file, key, text.encode())
            file.createDimension("sample", run.samples)
            for name, values in order_columns(run).items():
                is_int = values.dtype.kind == "i" and np.abs(values).max(initial=0) < INT32
                variable = file.createVariable(name, "i4" if is_int else "f8", ("sample",))
                variable[:] = values
                if name in UNITS:
                    variable.units = UNITS[name].encode()
            for shot in run.shots:
                _add_shot(file, shot)

    store_file(out, write_file, overwrite)


def _add_shot(file: Any, shot: Shot) -> None:
    """Add an accelerometer's record to a NetCDF file, with its own dimension."""
    name = f"shot{shot.number}"
    file.createDimension(f"{name}_sample", len(shot.counts))
    for column in ("time", "acceleration"):
        variable = file.createVariable(f"{name}_{column}", "f8", (f"{name}_sample",))
        variable[:] = getattr(shot, column)
        variable.units = UNITS[column].encode()
    for key, text in shot_metadata(shot).items():
        setattr(variable, key, text.encode())
