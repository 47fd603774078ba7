"""`export c`: what it writes, warns of and refuses; that it compiles without a warning."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from layerjam.brake.device.load import load
from layerjam.brake.kernel.compiler import SOURCES, find_compiler
from layerjam.brake.kernel.kernel import Kernel
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.cli.main import main
from layerjam.core.errors import FileError, QuantityError
from layerjam.interop.commands.export import export_c
from layerjam.interop.source import NAMES

WARNINGS = ("all", "extra", "conversion", "shadow", "error")
STRICT = ["-std=c99", "-ffreestanding", "-pedantic", *(f"-W{name}" for name in WARNINGS)]
CC = pytest.mark.skipif(
    shutil.which("cc") is None and shutil.which("gcc") is None, reason="no C compiler here"
)
ARM = pytest.mark.skipif(
    shutil.which("arm-none-eabi-gcc") is None, reason="arm-none-eabi-gcc is not installed"
)


def ran(*command: object) -> str:
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@CC
@pytest.mark.parametrize("precision", ["double", pytest.param("single", marks=pytest.mark.slow)])
def test_exported_brake_compiles_and_pulls_as_the_law_does(tmp_path, precision):
    made = export_c("choi2018-kapton", out=tmp_path / "made", precision=precision)
    assert sorted(made.files) == sorted(p.name for p in (tmp_path / "made").iterdir())
    ran(*find_compiler(), *STRICT, "-c", tmp_path / "made" / "layerjam.c", "-o", tmp_path / "k.o")
    program = tmp_path / "example"
    sources = [tmp_path / "made" / name for name in ("example.c", "layerjam.c")]
    ran(*find_compiler(), "-std=c99", "-Wall", "-Wextra", "-Werror", *sources, "-lm", "-o", program)
    rows = [list(map(float, line.split(","))) for line in ran(program).splitlines()[1:]]
    law = float(force_at_elongation(0.04, 94.5e3, load("choi2018-kapton")))
    top = next(force for elongation, force, _ in rows if elongation == 40)
    assert top == pytest.approx(law, abs=1e-4 if precision == "double" else 5e-3)
    assert made.state_bytes == len(Kernel(load("choi2018-kapton"), precision=precision).state)


@ARM
@pytest.mark.parametrize(
    "define",
    [(), pytest.param(("-DLJ_SINGLE", "-fno-math-errno"), marks=pytest.mark.slow)],
)
@pytest.mark.parametrize(
    ("chip", "most"),
    [
        pytest.param("m0plus", 12 * 1024, marks=pytest.mark.slow),
        ("m4", 12_000),
        pytest.param("m7", 12_000, marks=pytest.mark.slow),
    ],
)
def test_kernel_fits_a_microcontroller(tmp_path, chip, most, define):
    target = tmp_path / "k.o"
    command = ["arm-none-eabi-gcc", f"-mcpu=cortex-{chip}", "-mthumb", "-Os", "-ffp-contract=off"]
    ran(*command, *STRICT, *define, "-c", SOURCES / "layerjam.c", "-o", target)
    text, data, bss = map(int, ran("arm-none-eabi-size", target).splitlines()[1].split()[:3])
    assert (data, bss) == (0, 0) and text <= most
    wanted = {line.split()[1] for line in ran("arm-none-eabi-nm", "-u", target).splitlines()}
    named = {"sqrt", "pow", "sqrtf", "powf", "memcpy", "memset"}
    assert {name for name in wanted if not name.startswith("__aeabi")} <= named


def test_rope_counts_in_series_and_files_stay_unless_forced(tmp_path):
    soft = export_c("choi2018-kapton", out=tmp_path / "a", rope_stiffness="16.8 kN/m")
    k = 1 / (1 / 131e3 + 1 / 16.8e3)
    assert soft.parameters["stiffness"] == pytest.approx(k)
    assert soft.holds == pytest.approx(175.4298 * 101325 / 94.5e3, rel=1e-6)
    assert repr(soft.parameters["stiffness"]) in (tmp_path / "a" / "brake.h").read_text()
    (tmp_path / "a" / "mine.c").write_text("kept")
    with pytest.raises(FileError, match="already exists"):
        export_c("choi2018-kapton", out=tmp_path / "a")
    export_c("choi2018-ptfe", out=tmp_path / "a", overwrite=True)
    assert "ptfe" in (tmp_path / "a" / "brake.h").read_text()
    assert (tmp_path / "a" / "mine.c").read_text() == "kept"


def test_a_brake_that_would_snap_is_warned_of_and_not_written_when_strict(tmp_path, capsys):
    words = ["export", "c", "choi2018-kapton", "--rope-stiffness", "2kN/m", "--json", "--out"]
    assert main([*words, str(tmp_path / "a")]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["feasible"] and any("snap" in one for one in said["warnings"])
    assert (tmp_path / "a" / "brake.h").exists()
    assert main([*words, str(tmp_path / "b"), "--strict"]) == 1
    said = json.loads(capsys.readouterr().out)
    assert said["feasible"] is False and "1.97 kN/m" in said["reason"]
    assert not (tmp_path / "b").exists()


def test_warnings_have_keys(tmp_path):
    bent = load("choi2018-kapton").with_(pressure_exponent=0.1, test_pressure="3.9 kPa")
    made = export_c(bent, out=tmp_path / "a")
    assert "pow" in {getattr(one, "key", "") for one in made.warnings}
    unmeasured = load("choi2018-kapton").with_(stiffness_measured=None)
    assert any("stiffness" in one for one in export_c(unmeasured, out=tmp_path / "b").warnings)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"spacers": False}, "mount.spacers"),
        ({"rest_speed": 0.01, "test_speed": 0.01, "power": 0.1}, "speed_law"),
    ],
)
def test_what_is_not_in_the_kernel_is_refused_by_name(tmp_path, change, named):
    if named == "speed_law":
        text = load("choi2018-kapton").text
        file = tmp_path / "fast.toml"
        file.write_text(
            text + '\n[speed_law]\nrest_speed = "1 mm/s"\ntest_speed = "10 mm/s"\npower = 0.1\n'
        )
        brake = str(file)
    else:
        brake = load("choi2018-kapton").with_(**change)
    with pytest.raises(QuantityError) as caught:
        export_c(brake, out=tmp_path / "made")
    assert caught.value.quantity == named and not (tmp_path / "made").exists()


def test_commands_of_two_words_are_listed_and_found(capsys, tmp_path):
    assert main(["export"]) == 2
    assert "export is incomplete; type layerjam export c" in capsys.readouterr().err
    assert main(["export", "d", "choi2018-kapton"]) == 2
    assert "unknown command 'export d'; did you mean export c" in capsys.readouterr().err
    assert main(["export", "--help"]) == 0
    assert "export c" in capsys.readouterr().out
    assert main(["export", "c", "choi2018-kapton", "--out", str(tmp_path / "x" / "y")]) == 0
    assert {p.name for p in (tmp_path / "x" / "y").iterdir()} == set(NAMES)
    target = Path(tmp_path / "file")
    target.write_text("")
    assert main(["export", "c", "choi2018-kapton", "--out", str(target)]) == 2
    assert "is a file, not a folder" in capsys.readouterr().err
    assert main(["export", "c", "choi2018-kapton", "--out", "a", "--precision", "half"]) == 2
