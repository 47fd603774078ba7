"""The programs of docs/scpi.md, as they stand there but for the port."""

from __future__ import annotations

import re
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from importlib.util import find_spec

import pytest

from bench.rig.checks.served import ROOT, THEIRS, Served, environment, ours, serving

pytestmark = pytest.mark.slow
PREPARED = """
import sys
import layerjam.bench.rig
from layerjam.bench.control.settings import Regulator
from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.virtual_plant import read_hardware
made = read_hardware(address_of("sim:choi2018?at=40kPa"))
with layerjam.bench.rig.open(sys.argv[1]) as bench:
    bench.safe_state, bench.vent_rest = "release", "open"
    bench.regulator = Regulator(plant=made.plant, sensor=made.sensor, safe_state="release")
"""


@pytest.fixture(scope="module")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A gateway to a board that has a regulator."""
    with serving(tmp_path_factory.mktemp("ready"), "sim:choi2018?at=40kPa") as made:
        ran(ours(), PREPARED, f"tcp:127.0.0.1:{made.port}")
        yield made


def program(heading: str, at: Served) -> str:
    """The indented code under a heading of the page, for the port of this gateway."""
    page = (ROOT / "docs" / "scpi.md").read_text(encoding="utf-8")
    part = re.split(r"^### ", page.split(f"### {heading}\n")[1], flags=re.MULTILINE)[0]
    code = "\n".join(x for x in part.split("\n") if not x or x.startswith("    "))
    assert part.count("5025") >= 1 and len(code.strip().split("\n")) < 60
    return textwrap.dedent(code).replace("5025", str(at.port))


def ran(python: str, code: str, *words: str) -> str:
    made = subprocess.run(
        [python, "-c", code, *words],
        capture_output=True, text=True, timeout=120, check=False, env=environment(),
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    return made.stdout


def state(at: Served) -> str:
    code = "import sys, layerjam.rig; print(layerjam.bench.rig.open(sys.argv[1]).state)"
    return ran(ours(), code, f"tcp:127.0.0.1:{at.port}").strip()


def test_pyvisa(ready: Served, figure: Callable[[str], None]) -> None:
    pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks` has it")
    first, *rows = ran(sys.executable, program("PyVISA", ready)).splitlines()
    assert first.startswith("layerjam,virtual bench,") and len(rows) == 100
    assert all(row.endswith("kPa RUN") for row in rows)
    reached = float(rows[-1].split()[1])
    assert float(rows[0].split()[1]) < 20 and abs(reached - 40) < 1 and state(ready) == "SAFE"
    figure(f"    PyVISA as in docs/scpi.md: {reached:.2f} kPa of 40")


def test_a_plain_socket(ready: Served) -> None:
    said = ran(sys.executable, program("LabVIEW, MATLAB and other plain clients", ready))
    identity, error, layout, count = said.splitlines()
    assert identity.startswith("layerjam,virtual bench,") and error == '0,"No error"'
    assert "vacuum" in layout and re.fullmatch(r"[1-9]\d* records", count)


def test_bluesky(ready: Served, figure: Callable[[str], None]) -> None:
    """A scan of three points: its documents have the vacuum at each, and the bench ends safe."""
    if find_spec("bluesky") is None:
        pytest.skip("Bluesky is not installed: `make bench-checks` installs it")
    path = f"import sys; sys.path.append({THEIRS!r})\n"
    said = ran(ours(), path + program("Bluesky", ready))
    kinds = [line.split()[0] for line in said.splitlines() if line.endswith("}")]
    assert kinds == ["start", "descriptor", "event", "event", "event", "stop"], said
    seen = [float(v) for v in re.findall(r"'data': \{'vacuum': ([\d.]+)\}", said)]
    assert all(
        0.97 * due <= one <= 1.1 * due for one, due in zip(seen, (20e3, 30e3, 40e3), strict=True)
    )
    assert "'exit_status': 'success'" in said and state(ready) == "SAFE"
    figure(f"    Bluesky as in docs/scpi.md: scan at {', '.join(f'{v:.0f} Pa' for v in seen)}")
