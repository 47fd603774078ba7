"""Files of test machines, recognised by their content: structure and units, not brands.

A file is text or a workbook (`source`), its lines are numbers, words or blank (`lines`), a block of
numbers takes names and units from the words above it (`heads`, `table`), and each specimen in it
becomes a trace (`specimens`, `assemble`). Our own CSV is read by `own`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from layerjam.errors import FileError
from layerjam.measure.readers import own
from layerjam.measure.readers.answers import Opened, answers_beside, over
from layerjam.measure.readers.columns import Choices
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.source import load_sources
from layerjam.measure.readers.specimens import Specimen, specimens
from layerjam.measure.trace import Trace

__all__ = ["open_traces", "read_trace", "read_traces"]


def read_trace(path: str | Path, choices: Choices | None = None) -> Trace:
    """The trace in a test machine's file.

    `choices` answers what a file leaves open (sign, column, unit, decimal sign, specimen), before
    the [read] table of its sidecar does. Raises FileError, one sentence with the file and where
    known the line, for anything that cannot be read with certainty, and for a file of several
    specimens unless one is named.
    """
    choices = choices or Choices()
    found = open_traces(path, choices)
    if len(found) > 1:
        labels = [s.label for s in found if s.label]
        named = f" ({', '.join(repr(label[:30]) for label in labels[:6])})" if labels else ""
        raise FileError(path, f"holds {len(found)} specimens{named}; say which one (--specimen 1)")
    return found[0].read(choices)


def read_traces(path: str | Path, choices: Choices | None = None) -> list[Trace]:
    """Every specimen of a file as a trace of its own, in the file's order; else as `read_trace`."""
    choices = choices or Choices()
    return [one.read(choices) for one in open_traces(path, choices)]


def open_traces(path: str | Path, choices: Choices | None = None) -> list[Opened]:
    """The specimens of a file, each with `label` and `read(choices)`, none of them read yet.

    So that one damaged specimen does not take the others with it. Raises FileError where the file
    holds nothing that can be a tension test, and for a specimen that is not there.
    """
    beside = answers_beside(path)
    return [Opened(one, beside) for one in _open(path, over(choices or Choices(), beside))]


def _open(path: str | Path, choices: Choices) -> list[Specimen | own.Own]:
    sources = load_sources(path, choices.sheet)
    if sources[0].data.startswith(b"# layerjam"):
        return _one_of(sources[0].path, [own.Own(sources[0])], choices)
    if len(sources) == 1:
        return _one_of(sources[0].path, specimens(sources[0], choices), choices)
    return _one_of(sources[0].path, _of_sheets(sources, choices), choices)


def _of_sheets(sources: list[Source], choices: Choices) -> list[Specimen]:
    """The specimens of those sheets that hold any; FileError where their columns differ."""
    found: dict[str, list[Specimen]] = {}
    reasons: list[FileError] = []
    for source in sources:
        try:
            found[source.sheet] = specimens(source, choices)
        except FileError as err:
            reasons.append(err)
    if not found:
        raise max(reasons, key=lambda e: e.line or 0)
    heads = {(s[0].table.names, s[0].table.units) for s in found.values()}
    if len(heads) > 1 and choices.specimen is None:
        sheets = ", ".join(f"'{name[:30]}'" for name in list(found)[:6])
        raise FileError(
            sources[0].path,
            f"has {len(found)} sheets with force and elongation in different columns ({sheets}); "
            "say which one (--sheet NAME)",
        )
    return [
        one if one.label or len(found) == 1 else replace(one, label=sheet)
        for sheet, several in found.items()
        for one in several
    ]


def _one_of(
    path: str, found: list[Specimen] | list[own.Own], choices: Choices
) -> list[Specimen | own.Own]:
    if choices.specimen is None:
        return list(found)
    if choices.specimen > len(found):
        many = f"{len(found)} specimens" if len(found) > 1 else "1 specimen"
        raise FileError(path, f"holds {many}, there is no specimen {choices.specimen}")
    return [found[choices.specimen - 1]]
