"""Recorded bounds, defaults and named numbers of the modules that compute."""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
from collections.abc import Iterator, Mapping
from types import ModuleType
from typing import Any

import numpy as np

from layerjam.core.units import QuantitySpec
from mutant_draw import FOLDERS
from recorded.laws import totals


def modules() -> Iterator[ModuleType]:
    """Yield the modules of the folders that compute."""
    for folder in FOLDERS:
        name = "layerjam." + folder.replace("/", ".")
        package = importlib.import_module(name)
        for found in pkgutil.walk_packages(package.__path__, f"{name}."):
            yield importlib.import_module(found.name)


def list_module_numbers() -> dict[str, float | str]:
    """Return the totals of the numbers of each module."""
    found: dict[str, float | str] = {}
    for module in modules():
        numbers = np.array(list(read_module(module)))
        short = module.__name__.removeprefix("layerjam.")
        found |= {f"{short}.{key}": value for key, value in totals(numbers, 0.0)}
    return found


def read_module(module: ModuleType) -> Iterator[float]:
    for name, value in vars(module).items():
        if not isinstance(value, type) and name.lstrip("_").isupper():
            yield from read_numbers(value)
        elif dataclasses.is_dataclass(value) and value.__module__ == module.__name__:
            for field in dataclasses.fields(value):
                yield from read_numbers((field.default, dict(field.metadata)))


def read_numbers(value: Any) -> Iterator[float]:
    """Yield the numbers, but no flags, in nested tuples, mappings and bounds."""
    if isinstance(value, int | float | np.number) and not isinstance(value, bool):
        yield float(value)
    elif isinstance(value, QuantitySpec):
        yield from read_numbers(vars(value))
    elif isinstance(value, Mapping):
        for one in value.values():
            yield from read_numbers(one)
    elif isinstance(value, tuple | list | np.ndarray):
        for one in value:
            yield from read_numbers(one)
