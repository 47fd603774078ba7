"""A run for other programs: CSV with its sidecar, Parquet, NetCDF; each says what the run is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from layerjam.device.load import write_whole
from layerjam.errors import FileError, MissingExtraError
from layerjam.measure.run_text import SYNTHETIC, UNITS, csv_text, facts_of, in_order
from layerjam.measure.runs import Run, read_run
from layerjam.measure.sidecar import sidecar_path, write_facts

ENDINGS = (".csv", ".parquet", ".nc")
INT32 = 1 << 31


@dataclass(frozen=True, kw_only=True)
class ExportedRun:
    """What was written."""

    run: Run
    file: Path
    sidecar: Path | None


def export(
    run: str | Path,
    out: str | Path,
    *,
    start: float | None = None,
    end: float | None = None,
    force: bool = False,
) -> ExportedRun:
    """Write a run, or what of it lies from `start` to `end` [s], by the ending of `out`.

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
    sidecar = None
    if ending == ".csv":
        beside = sidecar_path(out)
        if beside.exists() and not force:
            raise FileError(beside, "exists already; --force replaces it")
        write_whole(out, csv_text(found), force)
        sidecar = write_facts(out, facts_of(found), force)
    elif ending == ".parquet":
        _parquet(found, out, force)
    else:
        _netcdf(found, out, force)
    return ExportedRun(run=found, file=out, sidecar=sidecar)


def said(run: Run) -> Mapping[str, str]:
    """What the run says of itself, and whether it is synthetic."""
    data = SYNTHETIC if run.simulated else "measured on a bench"
    return {"data": data, **{key: text for key, text in run.meta.items() if text}}


def _parquet(run: Run, out: Path, force: bool) -> None:
    with MissingExtraError.without("Parquet (pyarrow)", "sweep"):
        import pyarrow as pa  # type: ignore[import-untyped]
        import pyarrow.parquet as parquet  # type: ignore[import-untyped]
    fields = []
    for name, values in in_order(run).items():
        unit = {"unit": UNITS[name]} if name in UNITS else None
        fields.append(pa.field(name, pa.from_numpy_dtype(values.dtype), metadata=unit))
    schema = pa.schema(fields, metadata=dict(said(run)))
    table = pa.table(dict(in_order(run)), schema=schema)
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

    write_whole(out, fill, force)
