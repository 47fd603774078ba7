"""What `pip install layerjam` gives: the built wheel with its core alone, then with each extra.

Nothing is downloaded: the environment sees links to what is installed here, and pip itself says
whether that is what the wheel asks for.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from install.environment import ROOT, Environment, environment, serving
from laboratory.measure.test_specimens import xlsx

pytestmark = pytest.mark.slow

BRAKE = "choi2018-kapton"
AT = ("--slip", "20mm", "--vacuum", "50kPa")
PULL = "pull_choi2018-kapton_40kPa_19mms_1.csv"
NEEDS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("figures", ("force", BRAKE, *AT, "--figure", "new.svg")),
    ("labelled", ("tensile", BRAKE, "--vacuum", "50kPa", "--speed", "1mm/s", "--elongation", "4mm",
                  "--out", "new.nc")),
    ("report", ("scenario", "slow-stop", "--out", "new")),
    ("publish", ("publish", "campaign", "--brake", BRAKE, "--out", "new")),
    ("excel", ("pull", "book.xlsx")),
    ("units", ("force", BRAKE, "--slip", "0.0001furlong", "--vacuum", "94.5kPa")),
    ("bayes", ("calibrate", BRAKE, f"practice/{PULL}", "--depth", "bayesian")),
    ("sweep", ("sweep", "wrist", "--out", "new")),
    ("cluster", ("sweep", "wrist", "--out", "new", "--scheduler", "tcp://127.0.0.1:1")),
    ("workbench", ("workbench", "--no-show")),
    ("build", ("build", BRAKE, "--out", "new")),
    ("mujoco", ("export", "mujoco", BRAKE, "--out", "new")),
    ("bench", ("bench", "status", "serial:no-such-port")),
    ("visa", ("bench", "status", "visa:TCPIP::127.0.0.1::1::SOCKET")),
    ("records", ("records", "list", "--db", "new.db")),
    ("postgres", ("records", "list", "--db", "postgresql://127.0.0.1:1/none")),
    ("all", ("demo", "--out", "new")),
)  # fmt: skip
"""Extra: what a user types that needs it, and would write `new` if anything."""
OTHERWISE = {
    "pdf": "a report without it is written, and a note says so",
    "step": "a build without it is written, and a note says so",
    "fmu": "a C compiler: any other serves as well",
    "mjx": "no command: layerjam.interop.mjx",
    "docs": "of those who change layerjam",
    "test": "of those who change layerjam",
}
"""Extras whose lack no command of the list above is refused for."""
LOADED = {
    "cluster": "dask.distributed, pyarrow.parquet, layerjam.workshop.design.cluster",
    "bayes": "numpyro.infer.hmc, numpyro.diagnostics, layerjam.laboratory.identify.bayes.fit",
    "fmu": "ziglang",
    "mjx": "mujoco.mjx, layerjam.interop.mjx",
    "mujoco": "mujoco, layerjam.interop.mujoco, layerjam.interop.plugin",
    "step": "OCP.STEPControl, OCP.XCAFDoc, layerjam.workshop.fabricate.step",
    "visa": "pyvisa, pyvisa_py",
}
"""Extras whose use takes long or needs an instrument: what must be importable with them."""
APART = {"all", "report", "sweep", "workbench"}
"""Extras with a test of their own, or inside another one."""
ELSEWHERE = {"fmu", "mjx", "mujoco", "visa"}
"""Extras that `make test` does not install; looked at where they are."""


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    made = environment(tmp_path_factory.mktemp("install"))
    done = made.install()
    assert done.returncode == 0, done.stderr
    done = made.run("lab", "practice", "--out", "practice")
    assert done.returncode == 0, done.stderr
    numbers = [[0.1 * i, 2.0 * i] for i in range(60)]
    campaign = made.work / "campaign"
    campaign.mkdir()
    for name in (PULL, f"{PULL}.toml"):
        shutil.copy(made.work / "practice" / name, campaign)
    xlsx(made.work / "book.xlsx", {"Raw": [["Extension [mm]", "Force [N]"], *numbers]})
    return made


@pytest.fixture
def bare(core: Environment) -> Iterator[Environment]:
    """The environment with the core alone, and nothing that an earlier test wrote."""
    core.offer()
    core.clean()
    yield core


def test_the_wheel_is_whole(core: Environment) -> None:
    held = {
        p.relative_to(ROOT / "src").as_posix()
        for p in (ROOT / "src" / "layerjam").rglob("*")
        if p.is_file() and "__pycache__" not in p.parts and p.suffix != ".pyc"
    }
    assert held <= set(core.holds())


def test_every_extra_is_tried() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert set(project["optional-dependencies"]) == {extra for extra, _ in NEEDS} | set(OTHERWISE)


def test_the_core_alone_answers(bare: Environment) -> None:
    for words, said in (
        (("--help",), "Predict the behaviour of a brake"),
        (("show", BRAKE), "Kapton"),
        (("force", BRAKE, "--slip", "20mm", "--vacuum", "94.5kPa"), "133.9 N"),
        (("drop", BRAKE, "--mass", "1kg", "--speed", "2.5m/s", "--vacuum", "tuned", "--travel",
          "40mm"), "STOPPED"),
        (("pull", f"practice/{PULL}"), "peak"),
    ):  # fmt: skip
        done = bare.run(*words)
        assert done.returncode in (0, 1) and said in done.stdout, (words, done)
        assert "Traceback" not in done.stderr


@pytest.mark.parametrize(("extra", "words"), NEEDS, ids=[extra for extra, _ in NEEDS])
def test_what_an_extra_is_missing_for_says_which(
    extra: str, words: tuple[str, ...], bare: Environment
) -> None:
    done = bare.run(*words)
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(
        rf'layerjam: .*: \S.* install (-e )?"[^"]+\[{extra}\]"(, or give .*)?\n', done.stderr
    )
    assert not list(bare.work.glob("new*"))


def ends_well(extra: str, words: tuple[str, ...], done: subprocess.CompletedProcess[str]) -> None:
    if extra in ("bench", "postgres"):  # neither the port nor the server is there
        said = {"bench": "no-such-port: cannot be opened: ", "postgres": "Connection refused"}
        assert done.returncode == 2 and said[extra] in done.stderr
    else:
        assert done.returncode in (0, 1), (words, done.stderr)
    assert "pip install" not in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("extra", "words"),
    [(e, w) for e, w in NEEDS if e not in {*LOADED, *APART}],
    ids=str,
)
def test_with_its_extra_it_does_it(extra: str, words: tuple[str, ...], bare: Environment) -> None:
    bare.offer(extra)
    ends_well(extra, words, bare.run(*words))


@pytest.mark.parametrize("extra", LOADED)
def test_an_extra_brings_what_is_imported(extra: str, bare: Environment) -> None:
    try:
        bare.offer(extra)
    except LookupError as error:
        assert extra in ELSEWHERE, error
        pytest.skip(str(error))
    done = bare.code(f"import {LOADED[extra]}")
    assert done.returncode == 0, done.stderr


def test_a_report_is_a_pdf_with_its_extra(bare: Environment) -> None:
    words = ("report", BRAKE, "--pulls", f"practice/{PULL}", "--out", "new")
    for extra in ("report", "pdf"):
        bare.clean()
        bare.offer(extra)
        done = bare.run(*words)
        assert done.returncode in (0, 1, 3), done.stderr
        assert (bare.work / "new" / "report.html").is_file()
        assert (bare.work / "new" / "report.pdf").is_file() is (extra == "pdf")
        said = " ".join(done.stdout.split())
        assert ('[pdf]"' in said) is (extra == "report")


def test_the_workbench_opens_with_its_extra(bare: Environment) -> None:
    bare.offer("workbench")
    assert "layerjam" in serving(bare)


def test_pip_is_content_with_all(bare: Environment) -> None:
    names = bare.offer("all")
    done = bare.install("all")
    assert done.returncode == 0, done.stderr
    assert {"matplotlib", "pypdfium2", "nicegui", "sqlalchemy", "pyserial"} <= names


def test_the_environment_sees_nothing_else(bare: Environment) -> None:
    assert Path(
        bare.code("import layerjam; print(layerjam.__file__)").stdout.strip()
    ).is_relative_to(bare.folder)
    for name in ("matplotlib", "jinja2", "nicegui", "pytest"):
        assert "ModuleNotFoundError" in bare.code(f"import {name}").stderr
