"""The library for Windows under wine: it loads, reads its start values and gives the same bits."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from interop.importer import Unit
from layerjam.brake.kernel.compiler import SOURCES
from layerjam.interop import fmi
from layerjam.interop.commands.export import export_fmu

HERE = Path(__file__).parent
PATH = (1e-3, 20e-3, 19e-3, 5e-3, 39e-3)
WINE = next((name for name in ("wine", "wine64") if shutil.which(name)), None)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(WINE is None, reason="wine is not installed: Debian's package wine64"),
    pytest.mark.skipif(
        importlib.util.find_spec("ziglang") is None,
        reason='no compiler for Windows: pip install ".[fmu]"',
    ),
    pytest.mark.skipif(fmi.find_platform() != "linux", reason="compared with Linux on x86-64"),
]


def test_the_windows_library_gives_the_bits_of_the_linux_one(tmp_path):
    archive = tmp_path / "both.fmu"
    export_fmu("choi2018-kapton", out=archive, platforms="linux,windows")
    with zipfile.ZipFile(archive) as packed:
        packed.extractall(tmp_path / "unpacked")
    (library,) = (tmp_path / "unpacked" / "binaries" / "x86_64-windows").iterdir()
    program = tmp_path / "windows.exe"
    command = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu", "-O1"]
    about = [f"-I{fmi.UNIT}", f"-I{fmi.UNIT / 'headers'}", f"-I{SOURCES}"]
    subprocess.run([*command, *about, HERE / "windows.c", "-o", program], check=True)
    resources = "Z:" + str(tmp_path / "unpacked" / "resources") + "/"
    own = {**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"}
    done = subprocess.run(
        [WINE, program, "Z:" + str(library), resources, *map(repr, PATH)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env=own,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    linux = Unit(archive, tmp_path / "linux", "3")
    linux.start(vacuum=94.5e3)
    expected = []
    for i, elongation in enumerate(PATH):
        linux.set(elongation=elongation)
        linux.step(float(i), 1.0)
        expected.append(linux.get("force"))
    assert [float(word) for word in done.stdout.split()] == expected
    assert expected[-1] == pytest.approx(90.591778031, abs=1e-8)
