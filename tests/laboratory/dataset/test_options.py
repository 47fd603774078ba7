"""Whatever options `publish` accepts, an untouched dataset recomputes equal."""

from __future__ import annotations

import shutil
import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from counts import FULL
from laboratory.figures.brake_files import BRAKE, campaign
from layerjam.core.errors import MissingExtraError
from layerjam.laboratory.commands.calibration import calibrate
from layerjam.laboratory.commands.friction import FrictionTest
from layerjam.laboratory.commands.left_out import LeftOut
from layerjam.laboratory.commands.measurements import Measurements
from layerjam.laboratory.commands.publish import publish, recompute
from layerjam.laboratory.commands.reading import FileOptions
from layerjam.laboratory.figures import brake_files
from layerjam.laboratory.measure.sidecar import Facts, write_facts

pytestmark = pytest.mark.slow
PULLS, FRICTION = "pull-*.csv", "friction-*.csv"
Fault = Callable[[Path], None]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three friction tests, three pulls to calibrate on, four others, and a note."""
    folder = tmp_path_factory.mktemp("made")
    files = campaign(folder)
    for path in files.friction:
        write_facts(path, Facts(normal_force=2.45, brake=BRAKE, synthetic=True), overwrite=True)
    for path in files.validate[4:]:
        path.unlink()
        path.with_name(path.name + ".toml").unlink()
    (folder / "notes.txt").write_text("the third pull was done after lunch\n")
    return folder


@pytest.fixture(autouse=True)
def shorten_reports(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports without PDF, which repeats their pages, and figures without adjusted margins."""

    def missing(*_: Any) -> bytes:
        raise MissingExtraError("a page as PDF (typst)", "pdf")

    monkeypatch.setattr(brake_files, "typeset_pdf", missing)
    monkeypatch.setattr("matplotlib.layout_engine.ConstrainedLayoutEngine.execute", lambda *_: None)


def cut_off(name: str) -> Fault:
    def fault(folder: Path) -> None:
        lines = (folder / name).read_text().splitlines()
        (folder / name).write_text("\n".join(lines[: len(lines) // 2]) + "\n1,")

    return fault


def scaled(name: str, factor: float) -> Fault:
    """The last column times a factor, as if in another unit."""

    def fault(folder: Path) -> None:
        lines = (folder / name).read_text().splitlines()
        for index, line in enumerate(lines):
            rest, _, last = line.rpartition(",")
            cell = last.strip('"')
            if rest and cell.replace(".", "", 1).removeprefix("-").isdigit():
                lines[index] = f'{rest},"{float(cell) * factor:.9f}"'
        (folder / name).write_text("\n".join(lines) + "\n")

    return fault


def twin(name: str, other: str) -> Fault:
    """The same bytes under another name, with the same sidecar."""

    def fault(folder: Path) -> None:
        (folder / other).parent.mkdir(exist_ok=True)
        for end in ("", ".toml"):
            shutil.copy(folder / f"{name}{end}", folder / f"{other}{end}")

    return fault


def renamed(name: str, other: str) -> Fault:
    def fault(folder: Path) -> None:
        (folder / other).parent.mkdir(exist_ok=True)
        for end in ("", ".toml"):
            shutil.move(folder / f"{name}{end}", folder / f"{other}{end}")

    return fault


def nothing_stated(pattern: str) -> Fault:
    def fault(folder: Path) -> None:
        for path in folder.glob(pattern):
            path.with_name(path.name + ".toml").unlink()

    return fault


def calibrated(folder: Path) -> None:
    calibrate(BRAKE, sorted(folder.glob(PULLS)), out=folder / "calibrated.toml")


def unreadable(folder: Path) -> None:
    """A text with a sidecar, as of a measurement that was never exported."""
    (folder / "pull-9.csv").write_text("the export failed\n")
    write_facts(folder / "pull-9.csv", Facts(vacuum=94.5e3, brake=BRAKE, synthetic=True))


def only(pattern: str) -> Fault:
    def fault(folder: Path) -> None:
        keep = {*folder.glob(pattern)}
        for path in [*folder.glob("*.csv")]:
            if path not in keep:
                path.unlink()
                path.with_name(path.name + ".toml").unlink()

    return fault


def files(folder: Path, pattern: str) -> list[Path]:
    return sorted(folder.glob(pattern))


def pulls(folder: Path) -> dict[str, Any]:
    return {"pulls": files(folder, PULLS), "friction": files(folder, FRICTION)}


HOLDOUT = Measurements(holdout=["80.6 kPa"])
WHY = "the enclosure was torn"
CASES: dict[str, tuple[tuple[Fault, ...], Callable[[Path], dict[str, Any]]]] = {
    "nothing": ((), lambda _: {}),
    "a line and no author": ((), lambda _: {"line": "choi2018", "title": "Prüfung & <b>`x`"}),
    "holdout of a vacuum": ((), lambda _: {"measurements": HOLDOUT}),
    "holdout of a repeat": ((), lambda _: {"measurements": Measurements(holdout=["repeat 2"])}),
    "holdout of a speed": (
        (cut_off("pull-3.csv"),),
        lambda _: {"measurements": Measurements(holdout="7 mm/s")},
    ),
    "calibrate on": (
        (cut_off("check-80.6kPa-7mms-1.csv"),),
        lambda f: {"measurements": Measurements(calibrate_on=files(f, PULLS))},
    ),
    "calibrate on a damaged one": (
        (cut_off("pull-2.csv"),),
        lambda f: {"measurements": Measurements(calibrate_on=files(f, PULLS))},
    ),
    "validate others": (
        (),
        lambda f: {"measurements": Measurements(**pulls(f), validate=files(f, "check-*.csv"))},
    ),
    "validate alone": ((), lambda f: {"measurements": Measurements(validate=files(f, PULLS))}),
    "friction alone": ((), lambda f: {"measurements": Measurements(friction=files(f, FRICTION))}),
    "pulls in another order": (
        (cut_off("pull-2.csv"),),
        lambda f: {"measurements": Measurements(pulls=files(f, PULLS)[::-1])},
    ),
    "a pull named twice": (
        (),
        lambda f: {"measurements": Measurements(pulls=[*files(f, PULLS), f / "pull-1.csv"])},
    ),
    "no friction test": ((only("[pc]*.csv"),), lambda _: {}),
    "one pull": ((only("pull-1.csv"),), lambda _: {}),
    "one friction test": ((only("friction-1.csv"),), lambda _: {}),
    "a calibrated brake": ((calibrated,), lambda _: {}),
    "a calibrated brake and a damaged pull": (
        (calibrated, cut_off("check-80.6kPa-7mms-2.csv")),
        lambda _: {},
    ),
    "a damaged pull": ((cut_off("pull-2.csv"),), lambda _: {}),
    "a damaged friction test": ((cut_off("friction-2.csv"),), lambda _: {}),
    "a twin": ((twin("pull-1.csv", "pull-8.csv"),), lambda _: {}),
    "a twin of the same name": ((twin("pull-1.csv", "again/pull-1.csv"),), lambda _: {}),
    "equal names": (
        (renamed("pull-2.csv", "more/pull-1.csv"), cut_off("more/pull-1.csv")),
        lambda _: {},
    ),
    "equal names, one left out": (
        (renamed("pull-2.csv", "more/pull-1.csv"),),
        lambda f: {"left_out": LeftOut(exclude={str(f / "more" / "pull-1.csv"): WHY})},
    ),
    "an unreadable file": ((unreadable,), lambda _: {}),
    "a pull in another unit": ((scaled("pull-2.csv", 1e-3),), lambda _: {}),
    "no vacuum stated": ((nothing_stated("pull-3.csv"),), lambda _: {}),
    "the vacuum as an option": (
        (nothing_stated(PULLS),),
        lambda _: {"vacuum": "94.5 kPa", "options": FileOptions(speed=0.013)},
    ),
    "left out": ((), lambda f: {"left_out": LeftOut(exclude=["pull-3.csv"], because=[WHY])}),
    "left out and held out": (
        (cut_off("pull-2.csv"),),
        lambda f: {
            "measurements": HOLDOUT,
            "left_out": LeftOut(exclude={str(f / "check-80.6kPa-7mms-1.csv"): WHY}),
        },
    ),
    "curves": ((cut_off("pull-2.csv"),), lambda _: {"depth": "curves", "measurements": HOLDOUT}),
    "another atmosphere": ((), lambda _: {"atmosphere": "96 kPa"}),
    "a standard": (
        (),
        lambda _: {
            "test": FrictionTest(standard="iso8295", area="625 mm^2", normal_force="2.45 N")
        },
    ),
    "a window": (
        (),
        lambda _: {"test": FrictionTest(start="0.05 m", end="0.09 m", accept_stick_slip=True)},
    ),
    "columns": ((), lambda _: {"options": FileOptions(decimal=".", column=["force=Load"])}),
    "decomposed names": (
        (
            renamed("pull-1.csv", unicodedata.normalize("NFD", "Prüfung-1.csv")),
            cut_off(unicodedata.normalize("NFD", "Prüfung-1.csv")),
        ),
        lambda _: {},
    ),
    "an accepted failure": (
        (scaled("friction-2.csv", 1e-3),),
        lambda _: {},
    ),
    "a line, a standard and columns": (
        (),
        lambda _: {
            "line": "choi2018",
            "title": "Prüfung & <b>`x`",
            "test": FrictionTest(standard="iso8295", area="625 mm^2", normal_force="2.45 N"),
            "options": FileOptions(decimal=".", column=["force=Load"]),
        },
    ),
    "curves of some repeats elsewhere": (
        (cut_off("pull-2.csv"),),
        lambda _: {
            "depth": "curves",
            "measurements": Measurements(holdout=["repeat 2"]),
            "atmosphere": "96 kPa",
        },
    ),
    "odd files": (
        (
            unreadable,
            twin("pull-1.csv", "again/pull-1.csv"),
            renamed("pull-2.csv", unicodedata.normalize("NFD", "Prüfung-1.csv")),
            cut_off("friction-2.csv"),
        ),
        lambda _: {},
    ),
    "a window, no vacuum stated and one left out": (
        (nothing_stated("pull-3.csv"),),
        lambda _: {
            "test": FrictionTest(start="0.05 m", end="0.09 m", accept_stick_slip=True),
            "left_out": LeftOut(exclude=["pull-2.csv"], because=[WHY]),
        },
    ),
}
"""{name: (what happens to the folder, options)}."""
CONTAINED = {
    "nothing": "a line, a standard and columns",
    "holdout of a vacuum": "left out and held out",
    "calibrate on": "calibrate on a damaged one",
    "a calibrated brake": "a calibrated brake and a damaged pull",
    "a damaged pull": "pulls in another order",
    "a twin": "odd files",
    "a twin of the same name": "odd files",
    "an unreadable file": "odd files",
    "decomposed names": "odd files",
    "a damaged friction test": "odd files",
    "a line and no author": "a line, a standard and columns",
    "a standard": "a line, a standard and columns",
    "columns": "a line, a standard and columns",
    "curves": "curves of some repeats elsewhere",
    "another atmosphere": "curves of some repeats elsewhere",
    "holdout of a repeat": "curves of some repeats elsewhere",
    "a window": "a window, no vacuum stated and one left out",
    "no vacuum stated": "a window, no vacuum stated and one left out",
    "left out": "a window, no vacuum stated and one left out",
}
"""{case that `make slow` leaves to `make campaigns`: case that has the same options and more}."""


@pytest.mark.parametrize("name", [n for n in CASES if FULL or n not in CONTAINED])
def test_an_untouched_dataset_is_equal(made: Path, tmp_path: Path, name: str) -> None:
    faults, options = CASES[name]
    folder = tmp_path / "tests"
    shutil.copytree(made, folder)
    for fault in faults:
        fault(folder)
    out = tmp_path / "out"
    published = publish(folder, out=out, brake=BRAKE, **options(folder))
    if published.verdict == "failed":
        assert not out.exists()
        reasons = {row["name"]: f"accepted: {row['name']}" for row in published.failed_checks}
        published = publish(folder, out=out, brake=BRAKE, accept=reasons, **options(folder))
    assert published.folder is not None, published.failed_checks
    found = recompute(out)
    assert found.equal is True and found.exit_code == 0, str(found)
    assert str(tmp_path) not in (out / "recipe.json").read_text()
    assert ".layerjam-" not in (out / "recipe.json").read_text()
