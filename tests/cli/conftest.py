"""Run the command line inside this process, and the files it is run on."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from laboratory.campaigns import bench as virtual
from layerjam.brake.device.load import load
from layerjam.cli.main import main


@dataclass(frozen=True)
class Ran:
    """What a command printed and how it ended."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        def refuse(word: str) -> None:
            raise AssertionError(f"{word} is no JSON")

        found = json.loads(self.out, parse_constant=refuse)
        assert isinstance(found, dict)
        return found


Run = Callable[..., Ran]


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """`run("force", "choi2018-kapton", ...)`; file descriptors are watched, not only Python."""
    monkeypatch.setenv("COLUMNS", "80")

    def go(*words: object) -> Ran:
        capfd.readouterr()
        code = main([str(w) for w in words])
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err
        return Ran(code, out, err)

    return go


def contents(folder: Path) -> dict[str, bytes]:
    """Every file under a folder."""
    return {
        str(p.relative_to(folder)): p.read_bytes() if p.is_file() else b"/"
        for p in sorted(folder.rglob("*"))
    }


@pytest.fixture
def refuses(run: Run, tmp_path: Path) -> Callable[..., str]:
    """A command that must end with exit code 2, one sentence and nothing written."""

    def go(*words: object) -> str:
        before = contents(tmp_path)
        ran = run(*words)
        assert ran.code == 2, (ran.code, ran.out, ran.err)
        assert ran.out == ""
        assert ran.err.startswith("layerjam: ") and ran.err.endswith("\n")
        assert ran.err.count("\n") == 1, ran.err
        assert len(ran.err) < 500
        assert contents(tmp_path) == before
        return ran.err.removeprefix("layerjam: ").strip()

    return go


@dataclass(frozen=True)
class Files:
    """Synthetic files of the Kapton brake; `bare` ones have no sidecar."""

    friction: tuple[Path, ...]
    pulls: tuple[Path, ...]
    validation: tuple[Path, ...]
    bare: Path
    bare_friction: Path


MACHINE = virtual.Machine(sampling_rate=500.0, load_cell_noise=0.15, seed=21)
SLED = virtual.Machine(sampling_rate=25.0, load_cell_noise=0.002, load_cell_range=10.0, seed=22)


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    folder = tmp_path_factory.mktemp("measurements")
    brake = load("choi2018-kapton").brake
    sleds = []
    for repeat in (1, 2, 3):
        trace = virtual.friction(0.32, 0.24, 2.45, machine=SLED, repeat=repeat, static_sd=0.01,
                                 kinetic_sd=0.005, string_stiffness=30.0)  # fmt: skip
        sleds.append(virtual.write_bluehill(trace, folder / f"sled-{repeat}.csv"))
    pulls = []
    for repeat, (kind, ending) in enumerate((("testxpert", "TRA"), ("bluehill", "csv")), 1):
        trace = virtual.pull(brake, 94.5e3, 13e-3, 40e-3, MACHINE, repeat=repeat, name="choi")
        pulls.append(virtual.WRITERS[kind](trace, folder / f"pull-{repeat}.{ending}"))
    others = []
    for repeat, vacuum in enumerate((80.6e3, 46.1e3, 18.6e3), 11):
        trace = virtual.pull(brake, vacuum, 7e-3, 40e-3, MACHINE, repeat=repeat, name="choi")
        others.append(virtual.write_own(trace, folder / f"validation-{vacuum / 1e3}.csv"))
    bare, bare_sled = folder / "bare.csv", folder / "bare-sled.csv"
    bare.write_bytes(pulls[1].read_bytes())
    bare_sled.write_bytes(sleds[0].read_bytes())
    return Files(tuple(sleds), tuple(pulls), tuple(others), bare, bare_sled)
