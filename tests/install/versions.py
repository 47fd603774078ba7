"""The demo and the quick tests of the core with the oldest or the newest versions allowed.

`python tests/install/versions.py lowest|newest FOLDER [PYTHON]`: a fresh environment in a folder,
filled by uv with what pyproject.toml allows, then the demo and the tests. PYTHON is a version such
as 3.13, by default that of this process; if it is not on PATH, a sentence says so and nothing is
tried. Ends with the first failure.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[2]
RESOLUTION = {"lowest": "lowest-direct", "newest": "highest"}
CORE = ("core/toml_files", "brake/device", "brake/mechanics", "brake/simulate")
"""Folders of the tests that run."""
RUNNERS = ("hypothesis", "pytest", "pytest-xdist")


def requirements(project: dict[str, dict[str, list[str]]]) -> list[str]:
    """What runs the tests, at the bounds of the extra `test`."""
    listed = project["optional-dependencies"]["test"]
    return [text for text in listed if Requirement(text).name in RUNNERS]


def main() -> None:
    """Make the environment and run demo and tests in it."""
    which, folder = sys.argv[1], Path(sys.argv[2])
    interpreter = sys.argv[3] if len(sys.argv) > 3 else sys.executable
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    python = folder / "bin" / "python"
    uv = (sys.executable, "-m", "uv")
    find = (*uv, "python", "find", "-q", "--system", "--no-python-downloads", interpreter)
    if subprocess.run(find, capture_output=True, check=False).returncode:
        print(f"Python {interpreter} is not on PATH: not tried")
        return
    env = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    fresh = {**env, "XDG_CACHE_HOME": str(folder / "cache")}  # uv keeps its downloads
    # a version without a wheel would need compilers
    install = (
        "pip",
        "install",
        "-q",
        "--python",
        str(python),
        "--only-binary",
        ":all:",
        "--no-binary",
        "layerjam",
    )
    shutil.rmtree(folder, ignore_errors=True)
    for words in (
        (*uv, "venv", "-q", "--python", interpreter, str(folder)),
        (*uv, *install, "--resolution", RESOLUTION[which], f"{ROOT}[all]", *requirements(project)),
        (*uv, "pip", "freeze", "--python", str(python)),
        (str(python), "-m", "layerjam", "demo", "--out", str(folder / "demo")),
        (str(python), "-m", "pytest", "-q", "-n", "2", "--dist", "worksteal", "-m", "not slow",
         *(f"tests/{name}" for name in CORE)),
    ):  # fmt: skip
        print("$", *words, flush=True)
        own = words[0] == str(python)
        subprocess.run(words, cwd=ROOT, env=fresh if own else env, check=True)


if __name__ == "__main__":
    main()
