"""Numbers of commands, as they were: what changes between two versions changes on purpose.

Each command answers a few questions from files written here, and every number of its answer is
compared with the recorded one. After a change that is meant, `python -m recorded.record` in the
folder of the tests records them again, and the difference of `numbers.json` lists what has moved.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from recorded.cases import QUESTIONS, answer
from recorded.files import write_files
from recorded.record import read_recorded

LONG = ("calibrate curves", "publish", "tensile fan", "build")
LONG += ("build chain", "build own", "report", "saw mounted")
LONG += ("drop falling", "drop rising", "drop leaking", "saw damped")
LONG += ("drop speed-law", "laws rubber", "laws marches", "laws rubber that softens")
MARKS = {**dict.fromkeys(LONG, pytest.mark.slow), "tune speed-law": pytest.mark.campaign}
"""{question: when it is asked, if not by the quick tests}."""
CLOSE = 1e-6
"""Relative difference between machines: fits stop at a relative change of about 1e-8."""
ROUNDING = 1e-9
"""Largest size of a number that counts as rounding, beside one that is 1e15 times larger."""
MORE_STEPS = 0.1
"""Relative difference of the steps of searches: rounding may end one a step earlier."""
RECORDED = read_recorded()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("recorded") / "files"
    write_files(made)
    return made


@pytest.fixture
def inside(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(folder)
    yield


@pytest.mark.parametrize(
    "question",
    [pytest.param(q, marks=MARKS.get(q, ())) for q in QUESTIONS],
)
@pytest.mark.usefixtures("inside")
def test_a_command_answers_as_recorded(question: str) -> None:
    given, due = answer(QUESTIONS[question]), RECORDED[question]
    assert sorted(given) == sorted(due), "keys"
    words = {key: value for key, value in due.items() if isinstance(value, str)}
    assert {key: given[key] for key in words} == words
    numbers = {key: value for key, value in due.items() if key not in words}
    scale = min(max(map(abs, numbers.values()), default=0.0) * 1e-15, ROUNDING)
    moved = {
        key: (given[key], value)
        for key, value in numbers.items()
        if given[key] != close_to(key, value, scale)
    }
    assert not moved, "given and recorded"


def close_to(key: str, value: float, scale: float) -> object:
    """Return what a number of the answer must equal."""
    if key.endswith(".logarithms"):
        return pytest.approx(value, rel=0, abs=CLOSE)
    if key.endswith(".steps"):
        return pytest.approx(value, rel=MORE_STEPS)
    return pytest.approx(value, rel=CLOSE, abs=scale, nan_ok=True)


def test_every_answer_is_asked_for() -> None:
    assert RECORDED.keys() == QUESTIONS.keys()
