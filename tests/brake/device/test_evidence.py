"""[[tested]] in a brake's file: written, read again, and rejected if it is anything else."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.device.evidence import Evidence, Part, state_fitted
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, QuantityError

FILE = load("choi2018-kapton")
EVIDENCE = Evidence(
    command="calibrate",
    date="2026-11-28",
    tests=6,
    mountings=3,
    names=("scale_factor", "stiffness_measured", "enclosure_force"),
    exponent_sd=0.031,
    ranges={
        "vacuum": (40e3, 90e3),
        "slip": (0.0, 0.03),
        "speed": (0.013, 0.013),
        "force": (0.0, 171.25),
    },
    fitted=state_fitted("calibrate", FILE.known_values),
    parts=(
        Part("mean", ((1e-4, 2e-5, 0.0), (2e-5, 3e-4, 0.0), (0.0, 0.0, 0.0)), 2.0),
        Part("mean", ((1e-3, 0.0, -1e-3), (0.0, 0.0, 0.0), (-1e-3, 0.0, 0.09))),
        Part("test", ((6e-4, 0.0, 0.0), (0.0, 5e-4, 0.0), (0.0, 0.0, 0.0)), 3.0),
    ),
)


def test_evidence_survives_its_table() -> None:
    assert Evidence.read(EVIDENCE.to_toml()) == EVIDENCE


def test_evidence_survives_the_file() -> None:
    text = updated_text(FILE, "again", {}, evidence=EVIDENCE)
    again = BrakeFile.read(text, "again.toml")
    assert again.evidence == (EVIDENCE,)
    assert again.valid_evidence("calibrate") == EVIDENCE
    twice = updated_text(again, "twice", {}, evidence=EVIDENCE)
    assert BrakeFile.read(twice, "twice.toml").evidence == (EVIDENCE,)


def _without(key: str) -> Callable[[dict[str, Any]], Any]:
    return lambda row: row.pop(key)


WRONG: dict[str, Callable[[dict[str, Any]], Any]] = {
    **{key: _without(key) for key in ("names", "tests", "ranges", "command", "date", "parts")},
    "fitted": lambda row: row.update(fitted=3),
    "mountings": lambda row: row.update(mountings=0),
    "exponent_sd": lambda row: row.update(exponent_sd=-1.0),
    "reference_pressure": lambda row: row.update(reference_pressure=math.inf),
    "names: text": lambda row: row.update(names="scale_factor"),
    "names: twice": lambda row: row.update(names=["scale_factor", "scale_factor"]),
    "tests: none": lambda row: row.update(tests=0),
    "ranges: order": lambda row: row["ranges"].update(vacuum=["90 kPa", "40 kPa"]),
    "ranges: none": lambda row: row.update(ranges={}),
    "vacuum": lambda row: row["ranges"].pop("vacuum"),
    "slip": lambda row: row["ranges"].pop("slip"),
    "ranges: odd": lambda row: row["ranges"].update(colour=["90 kPa", "40 kPa"]),
    "parts: number": lambda row: row.update(parts=3),
    "parts: size": lambda row: row["parts"][0].update(covariance=[[1.0]]),
    "parts: degrees": lambda row: row["parts"][0].update(degrees=0.0),
    "parts: degrees in words": lambda row: row["parts"][0].update(degrees="many"),
    "parts: of": lambda row: row["parts"][0].pop("of"),
}


@pytest.mark.parametrize("key", WRONG)
def test_a_wrong_table_is_named(key: str) -> None:
    row = EVIDENCE.to_toml()
    WRONG[key](row)
    with pytest.raises(QuantityError, match=rf"tested.*\b{key.partition(':')[0]}\b"):
        Evidence.read(row)


@pytest.mark.parametrize(
    "matrix",
    [
        [[1e-4, 2e-3, 0.0], [2e-3, 1e-4, 0.0], [0.0, 0.0, 0.0]],
        [[1e-4, 1e-5, 0.0], [2e-5, 1e-4, 0.0], [0.0, 0.0, 0.0]],
        [[math.nan, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 0.0]],
        [[1e9, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 0.0]],
    ],
)
def test_a_matrix_that_is_no_covariance_is_rejected(matrix: list[list[float]]) -> None:
    row = EVIDENCE.to_toml()
    row["parts"][0]["covariance"] = matrix
    with pytest.raises(QuantityError, match="parts"):
        Evidence.read(row)


@pytest.mark.parametrize("name", ["scale_factor", "stiffness_measured"])
def test_a_fitted_number_without_uncertainty_is_rejected(name: str) -> None:
    row = EVIDENCE.to_toml()
    place = EVIDENCE.names.index(name)
    for part in row["parts"]:
        for i in range(3):
            part["covariance"][i][place] = part["covariance"][place][i] = 0.0
    with pytest.raises(
        QuantityError, match=rf"calibrate: the covariance of {name} is 0 .* variance above 0"
    ):
        Evidence.read(row)


def test_degrees_of_freedom_below_those_of_two_tests_are_rejected() -> None:
    row = EVIDENCE.to_toml()
    row["parts"][2]["degrees"] = 0.5
    with pytest.raises(QuantityError, match=r"degrees in parts is 0\.5; expected at least 1"):
        Evidence.read(row)
    row["parts"][2]["degrees"] = 1
    assert Evidence.read(row).parts[2].degrees == 1


def test_a_range_without_a_unit_is_named_with_its_value() -> None:
    row = EVIDENCE.to_toml()
    row["ranges"]["vacuum"] = ["40", "90 kPa"]
    with pytest.raises(QuantityError, match=r"ranges\.vacuum: '40' has no unit"):
        Evidence.read(row)


def test_an_unknown_key_is_named() -> None:
    with pytest.raises(QuantityError, match="unknown key surprise"):
        Evidence.read({**EVIDENCE.to_toml(), "surprise": 1})


def test_a_wrong_table_in_a_file_is_an_error_of_the_file() -> None:
    text = updated_text(FILE, "again", {}, evidence=EVIDENCE).replace("tests = 6", "tests = 0")
    with pytest.raises(FileError, match="tests"):
        BrakeFile.read(text, "again.toml")


def test_a_change_is_listed_with_its_values() -> None:
    values = {**FILE.known_values, "sheets.count": 13}
    assert EVIDENCE.find_changes(FILE.known_values) == {}
    assert EVIDENCE.find_changes(values) == {"sheets.count": (11, 13)}
