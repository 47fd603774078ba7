"""A data frame as a measurement, with columns read like those of a file."""

from dataclasses import replace
from typing import Any

from layerjam.core.errors import FileError
from layerjam.core.toml_files.values import entries
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.content import Source
from layerjam.laboratory.measure.readers.specimens import find_specimens
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Trace


def read_frame(frame: Any, options: ReadingOptions, number: int = 1) -> Trace:
    """Return the trace in a DataFrame; `number` counts the frames of one call.

    Columns are recognised by name and unit as in a file ("Force [N]"); `frame.attrs["units"]` may
    be {column: unit}, and other attributes state the conditions under the keys of a sidecar
    (`frame.attrs["vacuum"] = "67 kPa"`). A named index counts as a column. Raises FileError as for
    a file, and QuantityError for a condition that is out of bounds.
    """
    path = f"<DataFrame>/{number}"
    units = frame.attrs.get("units", {})
    table = frame.reset_index() if frame.index.name is not None else frame
    names = [f"{name} [{units[name]}]" if name in units else str(name) for name in table.columns]
    text = table.to_csv(index=False, header=names)
    if frame.empty:
        raise FileError(path, "is empty")
    try:
        specimens_read = find_specimens(Source(path, text.encode(), "utf-8", decimal="."), options)
    except FileError as error:
        if error.line or error.asks:
            raise
        raise FileError(
            path,
            f"has the columns {', '.join(names)[:200]}; name force and elongation with their "
            "units, such as 'Force [N]' and 'Elongation [mm]', or specify them",
            how=", such as column={'force:N': NAME, 'elongation:mm': NAME}",
            asks="columns",
        ) from None
    if len(specimens_read) > 1:
        raise FileError(
            path, f"contains {len(specimens_read)} specimens; pass a separate DataFrame for each"
        )
    trace = specimens_read[0].read(options)
    stated_facts = {
        name: entry.spec.si(frame.attrs[name], name)
        if hasattr(entry.spec, "si")
        else entry.spec.read(frame.attrs[name], name)
        for name, entry in entries(Facts)
        if name in frame.attrs
    }
    return replace(trace, facts=replace(trace.facts, **stated_facts))
