"""A bench run as CSV that every command reads, and the metadata for its sidecar."""

import io

from layerjam._version import __version__
from layerjam.brake.simulate.procedure import Evacuate, Pull, Return, parse_procedure
from layerjam.core.errors import LayerjamError
from layerjam.core.toml_files.table_text import comment
from layerjam.laboratory.measure.runs import Array, Run
from layerjam.laboratory.measure.shots import MEASURED, SYNTHETIC
from layerjam.laboratory.measure.sidecar import Facts

UNITS = {
    "time": "s",
    "elongation": "m",
    "force": "N",
    "vacuum": "Pa",
    "target": "Pa",
    "acceleration": "m/s^2",
}
FIRST = ("time", "elongation", "force", "vacuum", "target")
"""Columns that commands need, which come first; the board's own columns follow unchanged."""
LONG = 400
"""Largest number of characters in a metadata entry of a header."""


def order_columns(run: Run) -> dict[str, Array]:
    """Return the columns of a run, starting with those of FIRST."""
    names = [name for name in FIRST if name in run.columns]
    names += [name for name in run.columns if name not in names]
    return {name: run.columns[name] for name in names}


def format_run_csv(run: Run) -> str:
    """Return the run as text: a header with metadata, names with units, and rows of samples."""
    head = {"data": SYNTHETIC if run.simulated else MEASURED}
    head |= {key: text for key, text in run.meta.items() if text and key != "simulated"}
    short_entries = {
        key: text for key, text in head.items() if "\n" not in text and len(text) <= LONG
    }
    columns = order_columns(run)
    text = io.StringIO()
    text.write(f"# layerjam {__version__} bench export\n")
    text.writelines(comment(f"{key}: {value}") + "\n" for key, value in short_entries.items())
    names = (f"{name} [{UNITS[name]}]" if name in UNITS else name for name in columns)
    text.write(",".join(names) + "\n")
    cells = [_format_cells(name, values) for name, values in columns.items()]
    text.writelines(",".join(row) + "\n" for row in zip(*cells, strict=True))
    return text.getvalue()


def _format_cells(name: str, values: Array) -> list[str]:
    """Return numbers as text from which they are read unchanged; times are to the microsecond."""
    if name == "time":
        return [f"{value:.6f}" for value in values.tolist()]
    return list(map(repr, values.tolist()))


def make_run_facts(run: Run) -> Facts:
    """Return a run's metadata for its sidecar: vacuum, speed and whether it is synthetic.

    A vacuum or a speed is included only if the procedure has exactly one.
    """
    meta = run.meta
    vacuums, speeds = set(), set()
    try:
        steps = parse_procedure(meta.get("procedure", "")).steps
    except LayerjamError:
        steps = ()
    for step in steps:
        if isinstance(step, Evacuate):
            vacuums.add(step.to)
        elif isinstance(step, Pull | Return):
            speeds.add(step.speed)
    return Facts(
        vacuum=vacuums.pop() if len(vacuums) == 1 else None,
        speed=speeds.pop() if len(speeds) == 1 else None,
        brake=meta.get("brake") or None,
        procedure=meta.get("procedure") or None,
        synthetic=run.simulated,
        note=f"outcome {run.outcome or 'interrupted'}",
        number=meta.get("run_id", ""),
        date=meta.get("started_utc", "")[:10],
        operator=meta.get("operator", ""),
    )
