"""Choices for a build, from the [build] table of a brake's or a workshop's file, with sources."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.workshop import Build, Making, check_build
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.toml import find_line, read_text
from layerjam.core.toml_files.values import entries
from layerjam.core.units import check

TYPED = Source(kind="unstated", text="given with the command")
_FIELDS = dict(entries(Making))
_BUILD = {path: entry for path, entry in _FIELDS.items() if path.startswith("build.")}


@dataclass(frozen=True, kw_only=True)
class Choices:
    """Choices of one build, with a Source for every key of [build] that is set."""

    build: Build = Build()
    sources: Mapping[str, Source] = field(default_factory=dict)
    texts: Mapping[str, tuple[str, str]] = field(default_factory=dict, repr=False)
    """{dotted path: (file that sets it, its text)} for all values that come from a file."""

    @contextmanager
    def locate_errors(self) -> Iterator[None]:
        """Turn a QuantityError in the block into a FileError with its line if a file caused it.

        A value from the command or a default has no line; its error remains a QuantityError.
        """
        with _locate_error(self.texts):
            yield

    @property
    def default_keys(self) -> tuple[str, ...]:
        """Keys of [build] that are not set anywhere, so that their defaults apply."""
        names = (f.name for f in fields(self.build))
        return tuple(name for name in names if f"build.{name}" not in self.sources)


def resolve_choices(
    file: BrakeFile, workshop: str | Path | None = None, overrides: Mapping[str, Any] | None = None
) -> Choices:
    """Return the choices: the command overrides the brake's file, which overrides a workshop.

    `workshop` is the path of a TOML file with a [build] table; `overrides` maps keys of [build] to
    SI values. Raises FileError or QuantityError for values out of bounds or in conflict.
    """
    values: dict[str, Any] = {}
    sources: dict[str, Source] = {}
    texts: dict[str, tuple[str, str]] = {}
    if workshop is not None:
        reader = _read_workshop(Path(workshop))
        values, sources = dict(reader.values), dict(reader.sources)
        texts = dict.fromkeys(values, (str(reader.path), reader.text))
    if file.path:
        texts |= dict.fromkeys(file.sources, (file.path, file.text))
    for path, source in file.sources.items():
        if path in _BUILD:
            values[path] = getattr(file.making.build, path.removeprefix("build."))
            sources[path] = source
    for name, value in (overrides or {}).items():
        if value is not None:
            values[f"build.{name}"] = value
            sources[f"build.{name}"] = TYPED
            texts.pop(f"build.{name}", None)
    build = evolve(Build(), **{p.removeprefix("build."): v for p, v in values.items()})
    with _locate_error(texts):
        check(build, "build.")
        check_build(file.brake, build)
    return Choices(build=build, sources=sources, texts=texts)


@contextmanager
def _locate_error(texts: Mapping[str, tuple[str, str]]) -> Iterator[None]:
    try:
        yield
    except QuantityError as error:
        key = error.quantity or ""
        if key not in texts:
            raise
        path, text = texts[key]
        raise FileError(path, str(error), find_line(text, key)) from None


def _read_workshop(path: Path) -> Reader:
    text = read_text(path)
    reader = Reader(text, path, _BUILD)
    reader.read_all()
    if not reader.values:
        raise FileError(path, "has no [build] table with the workshop's choices")
    return reader


__all__ = ["TYPED", "Build", "Choices", "resolve_choices"]
