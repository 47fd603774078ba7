"""Ctrl-C at any moment: exit code 130, one line, and nothing written; or the whole result."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from counts import cases
from layerjam.core.errors import MissingExtraError

MOMENTS = cases(10, 2)
BEGIN = "from layerjam.cli.start import run; print('begins', flush=True); run()"
ENDED = {0, 3}
"""Exit codes of a whole result; 3 if a practice file was rejected."""
COMMANDS = {
    "publish": ["publish", "practice", "--brake", "choi2018-kapton", "--out"],
    "report": ["report", "choi2018-kapton", "--pulls", "PULLS", "--vacuum", "94.5kPa", "--out"],
    "calibrate": ["calibrate", "choi2018-kapton", "PULLS", "--out", "made.toml"],
    "build": ["build", "choi2018-kapton", "--out"],
    "lab": ["lab", "practice", "--out"],
    "design": ["design", "wrist", "--out", "made.toml"],
    "reproduce": ["reproduce", "--out"],
}
"""{command: words}; the last word is the file or folder to write, "made" if it is not given."""

pytestmark = [
    pytest.mark.timing,
    pytest.mark.slow,
    pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT for one process"),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("interrupted")
    run(["lab", "practice", "--out", "practice"], place, None)
    return place


def run(words: list[str], folder: Path, after: float | None) -> tuple[int, str, str, float]:
    """Return exit code, both outputs and duration of a command, interrupted after a time [s].

    Times count from the first line of the command's own code, not from the start of Python.
    """
    with subprocess.Popen(
        [sys.executable, "-c", BEGIN, *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        process_group=0,
    ) as process:
        assert process.stdout is not None and process.stdout.readline() == "begins\n"
        start = time.monotonic()
        if after is not None:
            try:
                process.wait(after)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=300)
    return process.returncode, out, err, time.monotonic() - start


def listed(place: Path) -> set[str]:
    if place.is_file():
        return {place.name}
    return {p.relative_to(place).as_posix() for p in place.rglob("*") if p.is_file()}


@pytest.mark.parametrize(
    "name", [*list(COMMANDS)[:-1], pytest.param("reproduce", marks=pytest.mark.campaign)]
)
def test_an_interrupt_leaves_nothing_or_everything(folder: Path, name: str) -> None:
    pulls = sorted(
        p.name for p in (folder / "practice").glob("pull_*_94.5kPa_*") if p.suffix != ".toml"
    )
    words = []
    for word in COMMANDS[name]:
        words += [f"practice/{p}" for p in pulls] if word == "PULLS" else [word]
    words += [] if words[-1].endswith(".toml") else ["made"]
    whole = folder / words[-1]

    def remove() -> set[str]:
        found = listed(whole) if whole.exists() else set()
        subprocess.run(["rm", "-rf", str(whole)], check=True)
        assert {p.name for p in folder.iterdir()} == {"practice"}
        return found

    code, _, _, duration = run(words, folder, None)
    assert code in ENDED
    every, draw = remove(), random.Random(name)
    assert every
    for _ in range(MOMENTS):
        moment = draw.uniform(0.1, duration)
        code, _, err, _ = run(words, folder, moment)
        left = remove()
        what = f"{name} after {moment:.2f} of {duration:.2f} s: {code}, {len(left)} files, {err}"
        lines = [line for line in err.splitlines() if "stopped" in line]
        if code == 130:
            assert not left and len(lines) == 1 and "Traceback" not in err, what
        elif code in (1, -signal.SIGINT):  # Python itself is already ending
            assert left in (set(), every) and "layerjam" not in err, what
        else:
            assert code in ENDED and left == every, what


LONG = {
    "stack": "tensile choi2018-kapton --vacuum 94.5kPa --speed 13mm/s --travel 3mm --model stack "
    "--scatter 10% --samples 10000000",
    "faults": "bench faults --runs 100000",
    "soak": "bench soak --hours 10000",
}
"""{case: a command that would run for hours and print a result}."""


@pytest.mark.parametrize("name", LONG)
def test_an_interrupt_prints_no_partial_result(folder: Path, name: str) -> None:
    for after in (1.0, 4.0, 9.0)[: cases(3, 2)]:
        code, out, err, _ = run(LONG[name].split(), folder, after)
        assert (code, out) == (130, ""), err
        assert err.count("stopped") == 1 and "Traceback" not in err


@pytest.mark.parametrize("chained", ["cause", "context"])
def test_an_interrupted_import_is_not_a_missing_package(chained: str) -> None:
    def load() -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as stop:
            if chained == "cause":
                raise ImportError("initialization failed") from stop
            raise ImportError("initialization failed")  # noqa: B904

    with pytest.raises(KeyboardInterrupt), MissingExtraError.raise_if_missing("a part", "step"):
        load()
    with pytest.raises(MissingExtraError), MissingExtraError.raise_if_missing("a part", "step"):
        raise ImportError("no module named 'part'")
