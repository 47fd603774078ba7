"""Files of test machines, recognised by their content; one module per machine's format.

A format is a module with `NAME`, `why_not(source, table)` (None where the file is of this format,
else the reason) and `read(source, table, choices)`; a new one is added to `FORMATS`.
"""

from __future__ import annotations

from pathlib import Path

from layerjam.errors import FileError
from layerjam.identify.columns import Choices
from layerjam.identify.readers import bluehill, own, testxpert
from layerjam.identify.readers.source import load_source
from layerjam.identify.readers.table import find_table
from layerjam.identify.trace import Trace

FORMATS = (own, testxpert, bluehill)


def read_trace(path: str | Path, choices: Choices | None = None) -> Trace:
    """The trace in a test machine's file, whichever of the known formats it is.

    `choices` answers what a file leaves open (sign, column, decimal sign). Raises FileError, one
    sentence with the file and where known the line, for anything that cannot be read with
    certainty; a file of no known format is told why each format said no.
    """
    source = load_source(path)
    table = find_table(source)
    reasons = []
    for form in FORMATS:
        reason = form.why_not(source, table)
        if reason is None:
            return form.read(source, table, choices or Choices())
        reasons.append(f"{form.NAME} ({reason})")
    raise FileError(source.path, f"is in no known format; tried {', '.join(reasons)}")
