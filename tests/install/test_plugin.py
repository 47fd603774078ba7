"""The example of a package that adds a command, an effect and a layout, installed and run."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from layerjam.brake.device.load import load

ROOT = Path(__file__).parents[2]
PLUGIN = ROOT / "examples" / "plugin"
PULL = """time [s]~Extension [mm]~Load [N]
{rows}
#END#
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the installed plug-in."""
    folder = tmp_path_factory.mktemp("site")
    words = ("-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation", "--no-index")
    command = [sys.executable, *words, "--target", str(folder), str(PLUGIN)]
    subprocess.run(command, check=True, capture_output=True)
    return folder


def run(site: Path, *words: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(site), *filter(None, sys.path)])
    return subprocess.run(
        [sys.executable, *words],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )


def test_its_command_has_help_text_json_and_a_function(site: Path) -> None:
    layerjam = ("-m", "layerjam")
    assert "\n  lift " in run(site, *layerjam, "help", "all").stdout
    page = run(site, *layerjam, "lift", "--help").stdout
    assert "how many times its own weight" in page and "--vacuum" in page
    words = ("lift", "choi2018-kapton", "--vacuum", "60kPa")
    assert "holding force" in run(site, *layerjam, *words).stdout
    values = json.loads(run(site, *layerjam, *words, "--json").stdout)
    code = "import layerjam as lj; print(lj.lift('choi2018-kapton', vacuum='60 kPa').weights)"
    assert float(run(site, "-c", code).stdout) == values["weights"]
    assert values["weights"] == pytest.approx(values["holding_force"] / (0.020 * 9.80665), rel=1e-3)
    wrong = run(site, *layerjam, "lift", "choi2018-kapton", "--vacuum", "60")
    assert wrong.returncode == 2 and "no unit" in wrong.stderr


def test_its_layout_is_read(site: Path, tmp_path: Path) -> None:
    file = tmp_path / "pull.txt"
    rows = (f"{i / 50:.2f}~{i * 0.02:.3f}~{min(i * 0.8, 80) - 0.02 * max(i - 100, 0):.3f}"
            for i in range(400))  # fmt: skip
    file.write_text(PULL.format(rows="\n".join(rows)), encoding="utf-8")
    read = run(site, "-m", "layerjam", "pull", str(file), "--json")
    assert read.returncode == 0, read.stderr
    assert json.loads(read.stdout)["pulls"][0]["peak_force"] == pytest.approx(80, abs=1)
    assert "separated by tildes" in run(site, "-m", "layerjam", "pull", str(file)).stdout
    alone = subprocess.run(
        [sys.executable, "-m", "layerjam", "pull", str(file)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert alone.returncode != 0


HUMIDITY = """
[effects.humidity]
humidity = { value = 0.8, kind = "measured", source = "hygrometer beside the rig" }
slope = 0.4
test_humidity = 0.3
"""
KAPTON = load("choi2018-kapton")
GRAVITY, SPRING = 9.80665, 131e3
"""Gravity [m/s^2]; stiffness of brake and rig [N/m], with a rigid rope."""


def rates(vacuum: float) -> tuple[float, float]:
    """Return c [N/m], with the factor of the humidity, and e [N/m^0.5] of eq. 3 of the paper."""
    sheets, enclosure, film = KAPTON.brake.sheets, KAPTON.brake.enclosure, KAPTON.brake.film
    c = 0.875 * 0.24 * (11 - 1) * 0.013 * vacuum * (1 + 0.4 * (0.8 - 0.3))
    face = enclosure.modulus * enclosure.wall * sheets.width
    e = 2 * math.sqrt(face * vacuum * film.friction_on_silicone * sheets.width)
    return c, e


def force(slip: float, vacuum: float) -> float:
    """Return the force [N], c (L2 - x) + e sqrt(x)."""
    c, e = rates(vacuum)
    return c * (0.068 - slip) + e * math.sqrt(slip)


def missing_energy(slip: float, vacuum: float) -> float:
    """Return the energy [J] of 1 kg at 2.5 m/s that a stop within a slip does not absorb."""
    c, e = rates(vacuum)
    work = c * (0.068 * slip - slip**2 / 2) + 2 / 3 * e * slip**1.5  # eq. 10
    load = force(slip, vacuum)
    fall = GRAVITY * (slip + load / SPRING)
    return 2.5**2 / 2 + fall - work - load**2 / (2 * SPRING)


def test_its_effect_acts_in_every_command(site: Path, tmp_path: Path) -> None:
    file = tmp_path / "humid.toml"
    file.write_text(KAPTON.text + HUMIDITY, encoding="utf-8")

    def values(*words: str) -> dict[str, float]:
        ran = run(site, "-m", "layerjam", words[0], str(file), *words[1:], "--json")
        assert ran.returncode == 0, ran.stderr
        numbers: dict[str, float] = json.loads(ran.stdout)
        return numbers

    pulled = values("force", "--vacuum", "80kPa", "--slip", "20mm")
    assert pulled["force"] == pytest.approx(force(0.02, 80e3), rel=1e-12)
    stop = ("--mass", "1kg", "--speed", "2.5m/s")
    dropped = values("drop", *stop, "--vacuum", "60kPa")
    assert missing_energy(dropped["slip"], 60e3) == pytest.approx(0, abs=1e-9)
    tuned = values("tune", *stop, "--travel", "40mm")
    assert missing_energy(0.04, tuned["vacuum"]) == pytest.approx(0, abs=1e-9)
    shown = run(site, "-m", "layerjam", "show", str(file))
    assert re.search(r"effects.humidity.humidity: .*hygrometer beside\s+the rig", shown.stdout)
    words = ("export", "fmu", str(file), "--out", str(tmp_path / "unit"))
    refused = run(site, "-m", "layerjam", *words)
    assert refused.returncode == 2
    assert "effects.humidity: an FMU does not have this effect" in refused.stderr


def test_a_file_with_its_effect_says_what_to_install(tmp_path: Path) -> None:
    file = tmp_path / "humid.toml"
    file.write_text(KAPTON.text + HUMIDITY, encoding="utf-8")
    alone = subprocess.run(
        [sys.executable, "-m", "layerjam", "show", str(file)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert alone.returncode == 2
    assert "effects.humidity: no installed package provides it" in alone.stderr
    assert "install the one that has 'humidity' as an entry point" in alone.stderr
