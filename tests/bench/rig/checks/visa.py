"""PyVISA as its users write it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from bench.rig.checks.served import Served

pyvisa = pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks`")
ENDS = {"read_termination": "\n", "write_termination": "\n"}


@contextmanager
def opened(resource: str, **more: Any) -> Iterator[Any]:
    manager = pyvisa.ResourceManager("@py")
    made = manager.open_resource(resource, **more)
    try:
        yield made
    finally:
        # the manager is the same for all that a program opens, and would close them all
        made.close()


@contextmanager
def client(served: Served) -> Iterator[Any]:
    """A client on the socket, its queue empty."""
    with opened(served.resource, **ENDS) as made:
        made.write("*CLS")
        yield made


def error(made: Any) -> int:
    return int(made.query("SYST:ERR?").split(",")[0])


def timed(made: Any, query: str, count: int) -> list[float]:
    """Seconds of each of so many queries, shortest first."""
    out = []
    for _ in range(count):
        begun = time.perf_counter()
        made.query(query)
        out.append(time.perf_counter() - begun)
    return sorted(out)
