"""The choices behind a build: the [build] table of a brake or a workshop, with their sources."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from layerjam.device.file import BrakeFile
from layerjam.device.workshop import Build, Making, check_build
from layerjam.errors import FileError, QuantityError
from layerjam.records.reader import Reader
from layerjam.records.source import Source
from layerjam.records.toml import line_of, read_text
from layerjam.records.values import entries
from layerjam.units import check

TYPED = Source(kind="unstated", text="given with the command")
_FIELDS = dict(entries(Making))
_BUILD = {path: entry for path, entry in _FIELDS.items() if path.startswith("build.")}


@dataclass(frozen=True, kw_only=True)
class Choices:
    """The choices of one build, with a Source for every key of [build] that somebody gave."""

    build: Build = Build()
    sources: Mapping[str, Source] = field(default_factory=dict)
    texts: Mapping[str, tuple[str, str]] = field(default_factory=dict, repr=False)
    """{dotted path: (file that gives it, its text)} of all that a file gives and counts."""

    @contextmanager
    def located(self) -> Iterator[None]:
        """A QuantityError inside becomes a FileError with file and line where a file is at fault.

        What the command or nobody gave has no line, and stays a QuantityError.
        """
        with _located(self.texts):
            yield

    @property
    def assumed(self) -> tuple[str, ...]:
        """Keys of [build] that nobody gave and whose default therefore counts."""
        known = (f.name for f in fields(self.build))
        return tuple(name for name in known if f"build.{name}" not in self.sources)


def choices(
    file: BrakeFile, workshop: str | Path | None = None, given: Mapping[str, Any] | None = None
) -> Choices:
    """What was chosen: what the command gives counts most, then the brake's file, then a workshop.

    `workshop` is the path of a TOML file with a table [build]; `given` maps keys of [build] to SI
    values. Raises FileError or QuantityError for what is not allowed or contradicts itself.
    """
    values: dict[str, Any] = {}
    sources: dict[str, Source] = {}
    texts: dict[str, tuple[str, str]] = {}
    if workshop is not None:
        reader = _workshop(Path(workshop))
        values, sources = dict(reader.values), dict(reader.sources)
        texts = dict.fromkeys(values, (str(reader.path), reader.text))
    if file.path:
        texts |= dict.fromkeys(file.sources, (file.path, file.text))
    for path, source in file.sources.items():
        if path in _BUILD:
            values[path] = getattr(file.making.build, path.removeprefix("build."))
            sources[path] = source
    for name, value in (given or {}).items():
        if value is not None:
            values[f"build.{name}"] = value
            sources[f"build.{name}"] = TYPED
            texts.pop(f"build.{name}", None)
    made = replace(Build(), **{p.removeprefix("build."): v for p, v in values.items()})
    with _located(texts):
        check(made, "build.")
        check_build(file.brake, made)
    return Choices(build=made, sources=sources, texts=texts)


@contextmanager
def _located(texts: Mapping[str, tuple[str, str]]) -> Iterator[None]:
    try:
        yield
    except QuantityError as error:
        named = error.quantity or ""
        if named not in texts:
            raise
        path, text = texts[named]
        raise FileError(path, str(error), line_of(text, named)) from None


def _workshop(path: Path) -> Reader:
    """The [build] table of a workshop's file."""
    text = read_text(path)
    reader = Reader(text, path, _BUILD)
    reader.take()
    if not reader.values:
        raise FileError(path, "has no table [build]; it says what a workshop cuts and prints")
    return reader


__all__ = ["TYPED", "Build", "Choices", "choices"]
