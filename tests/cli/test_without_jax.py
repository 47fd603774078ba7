"""First answers without a compiler: JAX and numba are neither imported nor needed."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from layerjam.brake.kernel.compiler import find_compiler
from layerjam.core.errors import CompilerError

ABSENT = ("jax", "jaxlib", "llvmlite", "numba")
BRAKE = "choi2018-kapton"
STOP = (BRAKE, "--mass", "1kg", "--speed", "2.5m/s", "--travel", "40mm")
CASES: dict[str, tuple[str, ...]] = {
    "force": ("force", BRAKE, "--slip", "20mm", "--vacuum", "94.5kPa"),
    "vacuum": ("vacuum", BRAKE, "--slip", "20mm", "--force", "100N"),
    "drop": ("drop", *STOP, "--vacuum", "tuned"),
    "tune": ("tune", *STOP),
    "tensile": (
        "tensile",
        BRAKE,
        "--vacuum",
        "94.5kPa",
        "--speed",
        "13mm/s",
        "--elongation",
        "40mm",
    ),
    "rise": ("rise", "choi2018", "--target", "80kPa", "--fluid", "air"),
    "parts": ("parts", "choi2018-pair"),
    "show": ("show", BRAKE),
    "bench run": (
        *("bench", "run", "sim:choi2018?speed=0", "--procedure", "evacuate to 40 kPa; vent"),
        *("--brake", BRAKE, "--line", "choi2018", "--safe-state", "release"),
        *("--vent-rest", "open", "--sensor-range", "103kPa", "--out", "first.ljrun"),
    ),
}
"""{what is asked: a command line}."""
VARIES = re.compile(r"^run id .*|\d[\d.]*", re.M)
"""Name and numbers of a run, which differ: when a board is asked depends on the machine."""
NOTHING = re.compile(r"(?!)")
README = """
import layerjam as lj
stop = lj.drop("choi2018-kapton", mass="1 kg", speed=2.5, vacuum="tuned", travel=0.04)
print(f"{stop.vacuum / 1e3:.2f} kPa, {stop.peak_force:.1f} N")
"""
SCRIPT = f"""
import contextlib, io, json, sys
def answer(ask):
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        try:
            code = ask()
        except Exception as error:
            code = repr(error)
    return code, out.getvalue()
given = json.loads(sys.argv[1])
answers = {{"README": answer(lambda: exec({README!r}))}}
from layerjam.cli.main import main
answers |= {{name: answer(lambda: main(words)) for name, words in given.items()}}
loaded = [name for name in {ABSENT} if name in sys.modules]
print(json.dumps({{"answers": answers, "loaded": loaded}}))
"""


def ask(folder: Path, *before: Path) -> dict[str, Any]:
    """What a process in an empty folder answers, with folders before all others to import from."""
    folder.mkdir()
    path = os.pathsep.join([*map(str, before), *filter(None, sys.path)])
    env = {**os.environ, "PYTHONPATH": path, "XDG_CACHE_HOME": str(folder / "cache")}
    words = (sys.executable, "-c", SCRIPT, json.dumps(CASES))
    done = subprocess.run(words, cwd=folder, env=env, capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], dict[str, Any]]:
    """Answers where JAX can be imported, and where it cannot."""
    folder = tmp_path_factory.mktemp("answers")
    stubs = folder / "stubs"
    stubs.mkdir()
    for name in ABSENT:
        code = f"raise ModuleNotFoundError(name={name!r})\n"
        (stubs / f"{name}.py").write_text(code, encoding="utf-8")
    return ask(folder / "with"), ask(folder / "without", stubs)


@pytest.mark.parametrize("name", ["README", *CASES])
def test_an_answer_needs_no_compiler_and_is_the_same(
    name: str, both: tuple[dict[str, Any], dict[str, Any]]
) -> None:
    if name in ("tensile", "bench run"):
        needs_kernel()
    numbers = VARIES if name == "bench run" else NOTHING
    with_jax, without = (
        [found["answers"][name][0], numbers.sub("", found["answers"][name][1])] for found in both
    )
    assert without == with_jax
    assert without[0] in (0, None), without
    assert len(without[1]) > 10


def test_none_is_loaded_although_it_could_be(
    both: tuple[dict[str, Any], dict[str, Any]],
) -> None:
    needs_kernel()
    assert both[0]["loaded"] == []


def needs_kernel() -> None:
    """Skip where pulls have no compiled kernel."""
    try:
        find_compiler()
    except CompilerError as error:
        pytest.skip(f"the kernel of pulls cannot be built: {error}")
