"""What the checks share: one gateway, the programs they need, the figures printed at the end."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator

import pytest

from bench.rig.checks.served import Served, serving

FIGURES: list[str] = []


@pytest.fixture(scope="session")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(tmp_path_factory.mktemp("bench"), "sim:choi2018") as made:
        yield made


@pytest.fixture
def tool() -> Callable[[str], str]:
    """The path of a program, or a skipped test."""

    def find(name: str) -> str:
        found = shutil.which(name)
        if found is None:
            pytest.skip(f"{name} is not installed: `make bench-checks` installs it where it can")
        return found

    return find


@pytest.fixture
def figure() -> Callable[[str], None]:
    """Keep a line for the end of the run."""
    return FIGURES.append


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if FIGURES:
        terminalreporter.section("figures")
        for line in sorted(FIGURES):
            terminalreporter.write_line(line)
