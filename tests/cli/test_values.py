"""The check values of mechanics.md, typed at the command line."""

from __future__ import annotations

import pytest

from .conftest import Run


def prints(value: float, text: str) -> bool:
    """Whether a number, rounded to the digits of `text`, is `text`."""
    return f"{value:.{len(text.partition('.')[2])}f}" == text


@pytest.mark.parametrize(
    ("slip", "key", "text"),
    [
        ("0 mm", "sheet_friction", "175.4298"),
        ("20mm", "force", "133.942755"),
        ("40 mm", "force", "86.5334362"),
        ("4cm", "force", "86.5334362"),
    ],
)
def test_force_of_kapton(run: Run, slip: str, key: str, text: str) -> None:
    ran = run("force", "choi2018-kapton", "--slip", slip, "--vacuum", "94.5kPa", "--json")
    assert prints(ran.json[key], text)
    assert ran.json["force"] == ran.json["sheet_friction"] + ran.json["enclosure_force"]


def test_force_of_ptfe(run: Run) -> None:
    ran = run("force", "choi2018-ptfe", "--slip", "0m", "--vacuum", "94500 Pa", "--json")
    assert prints(ran.json["force"], "51.79356") and ran.json["enclosure_force"] == 0


@pytest.mark.parametrize(
    ("brake", "expected"),
    [
        ("choi2018-kapton", {"peak_force": "175.925038", "peak_elongation": "1.53490313",
                             "force_at_end": "88.1486228", "work": "5.30546849"}),
        ("choi2018-ptfe", {"peak_force": "52.2758181", "peak_elongation": "1.58362822",
                           "force_at_end": "29.3481365", "work": "1.65910443"}),
    ],
)  # fmt: skip
def test_tensile(run: Run, brake: str, expected: dict[str, str]) -> None:
    ran = run("tensile", brake, "--vacuum", "94.5 kPa", "--speed", "13 mm/s",
              "--elongation", "40 mm", "--json")  # fmt: skip
    assert ran.code == 0 and ran.json["outcome"] == "FINISHED"
    for key, text in expected.items():
        scale = 1e3 if key == "peak_elongation" else 1.0
        assert prints(ran.json[key] * scale, text), (key, ran.json[key])
    assert 0.8 * ran.json["work"] < ran.json["dissipated_energy"] < ran.json["work"]


def test_past_the_overlap_it_separates(run: Run) -> None:
    ran = run("tensile", "choi2018-kapton", "--vacuum", "94.5kPa", "--speed", "13mm/s",
              "--elongation", "80mm", "--json")  # fmt: skip
    assert ran.code == 0 and ran.json["outcome"] == "SEPARATED"
    assert ran.json["force_at_end"] == pytest.approx(18.6, abs=0.1)  # what the sleeve carries
    shown = run("tensile", "choi2018-kapton", "--vacuum", "94.5kPa", "--speed", "13mm/s",
                "--elongation", "80mm")  # fmt: skip
    assert shown.code == 0 and "SEPARATED" in shown.out


def test_vacuum_is_the_inverse(run: Run) -> None:
    for slip, force in (("20mm", "133.942755"), ("40mm", "86.5334362")):
        ran = run("vacuum", "choi2018-kapton", "--slip", slip, "--force", f"{force} N", "--json")
        assert ran.code == 0 and ran.json["vacuum"] == pytest.approx(94.5e3, rel=1e-8)
    for words in (("0mm", "175.4298N"),):
        ran = run("vacuum", "choi2018-kapton", "--slip", words[0], "--force", words[1], "--json")
        assert ran.json["vacuum"] == pytest.approx(94.5e3, rel=1e-12)


def test_show_of_kapton(run: Run) -> None:
    found = run("show", "choi2018-kapton", "--json").json
    for key, scale, text in (
        ("stiffness_before_slip", 1e-3, "808"),
        ("stiffness_sliding", 1e-3, "2047"),
        ("stiffness_measured", 1e-3, "131"),
        ("stiffness_mount", 1e-3, "156"),
        ("usable_travel", 1e3, "60"),
        ("mass", 1e3, "20"),
        ("energy_capacity", 1.0, "7.03"),
        ("peak_vacuum", 1e-3, "1.06"),
    ):
        assert prints(found[key] * scale, text), (key, found[key])
    # 234 N at 94.5 kPa, scaled to p_atm
    assert found["holding_force"] == pytest.approx(0.875 * 0.32 * 10 * 0.013 * 0.068 * 101325)
    assert found["max_force"] == pytest.approx(188.6, abs=0.1)


def test_show_of_ptfe(run: Run) -> None:
    found = run("show", "choi2018-ptfe", "--json").json
    for key, text in (("stiffness_sliding", "409"), ("stiffness_measured", "55"),
                      ("stiffness_mount", "83")):  # fmt: skip
        assert prints(found[key] / 1e3, text)
    assert prints(found["mass"] * 1e3, "20") and prints(found["peak_vacuum"] / 1e3, "3.58")


def test_one_more_sheet(run: Run, tmp_path) -> None:
    """17.5 N per added sheet: 17.543 N of friction an interface."""
    from layerjam.brake.device.load import load

    text = load("choi2018-kapton").text.replace("value = 11,", "value = 12,")
    (tmp_path / "twelve.toml").write_text(text)
    words = ("--slip", "0mm", "--vacuum", "94.5kPa", "--json")
    more = run("force", tmp_path / "twelve.toml", *words).json["force"]
    now = run("force", "choi2018-kapton", *words).json["force"]
    assert prints(more - now, "17.543")
    peaks = [
        run("tensile", brake, "--vacuum", "94.5kPa", "--speed", "1mm/s", "--elongation", "5mm",
            "--json").json["peak_force"]
        for brake in (tmp_path / "twelve.toml", "choi2018-kapton")
    ]  # fmt: skip
    assert prints(peaks[0] - peaks[1], "17.5")
