"""Campaigns: the spec's file, the plan, the folder, and the truth back through every layout."""

from __future__ import annotations

import itertools
import re
import tomllib
from collections.abc import Callable
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, LayerjamError, QuantityError, UnknownNameError
from layerjam.laboratory.campaigns.campaign import campaign
from layerjam.laboratory.campaigns.campaign_files import file_name, select_form, write_campaign
from layerjam.laboratory.campaigns.exports import ENCODINGS, LANGUAGES, LAYOUTS, Form
from layerjam.laboratory.campaigns.spec import (
    TABLES,
    Faults,
    Files,
    FrictionTests,
    Practice,
    Pulls,
    Scatter,
    Spec,
    Truth,
    check_spec,
)
from layerjam.laboratory.campaigns.text import example_spec, format_spec, parse_spec, read_spec
from layerjam.laboratory.commands.calibration import calibrate
from layerjam.laboratory.commands.friction import friction
from layerjam.laboratory.identify.calibration.peaks import fit_pull
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.measure.sidecar import read_facts

SMALL = Spec(
    brakes=(Truth(brake="choi2018-kapton"),),
    pulls=Pulls(vacuums=(94.5e3,), speeds=(13e-3,), repeats=2),
    machine=Faults(sampling_rate=200.0, force_noise=0.15, force_step=1e-3, travel_step=1e-7),
)


def made(spec: Spec, **tables: Any) -> Spec:
    """The spec with some of its tables' values changed."""
    return replace(spec, **{k: replace(getattr(spec, k), **v) for k, v in tables.items()})


# --- the spec's file


def test_the_example_says_what_is_allowed_and_reads_as_itself() -> None:
    spec = example_spec()
    text = format_spec(spec)
    assert parse_spec(text, "x") == spec
    for table, cls in TABLES.items():
        for place in fields(cls):
            assert f"\n{place.name} =" in text or f"\n# {place.name} =" in text, (table, place.name)
            spec = place.metadata.get("quantity")
            if spec is not None:
                assert f"# {spec.text}" in text and spec.limits() in text


def test_the_pages_campaign_can_be_run() -> None:
    page = Path(__file__).resolve().parents[3] / "docs" / "virtual-laboratory.md"
    text = page.read_text(encoding="utf-8")
    (block,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    assert len(campaign(parse_spec(block, "page")).tests) == 6
    for table in ("machine", "practice"):
        for place in fields(TABLES[table]):
            assert f"`{place.name}`" in text or place.name == "sampling_rate", place.name


def test_what_is_left_out_is_as_the_defaults_say() -> None:
    spec = parse_spec('[[brakes]]\nbrake = "choi2018-ptfe"\n[pulls]\nvacuums = ["50 kPa"]', "x")
    assert spec == Spec(brakes=(Truth(brake="choi2018-ptfe"),), pulls=Pulls(vacuums=(50e3,)))


@given(
    st.floats(0, 1e3), st.floats(1.0, 1e6), st.integers(0, 2**63 - 1), st.floats(-2, 2),
    st.sampled_from(list(LAYOUTS)), st.sampled_from(list(LANGUAGES)),
)  # fmt: skip
def test_every_spec_comes_back_from_its_text(
    noise: float, rate: float, seed: int, start: float, layout: str, language: str
) -> None:
    spec = replace(
        SMALL,
        seed=seed,
        machine=Faults(sampling_rate=rate, force_noise=noise, crosshead_start=start),
        files=Files(layouts=(layout,), language=language, encoding="utf-8"),
    )
    assert parse_spec(format_spec(spec), "x") == spec


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("[machine]\nforce_noise = 0.1", 2, "machine.force_noise: 0.1 has no unit; write '0.1 N'"),
        ('[machine]\n\nforce_noise = "-1 N"', 3, "force_noise: -1 N is not allowed"),
        ('[machine]\nnoise = "1 N"', 2, "unknown key 'machine.noise'; did you mean machine.for"),
        ("[pulls]\nrepeats = 1.5", 2, "must be an integer"),
        ('[pulls]\nvacuums = "40 kPa"', 2, "must be a list"),
        ('[pulls]\nvacuums = ["40 kPa", "40 kPa"]', 2, "the same value twice"),
        ('[files]\nlayouts = ["excel"]', 2, "unknown layouts 'excel'"),
        ('[files]\nencoding = "latin-1"\nlanguage = "ja"\nlayouts = ["mts"]', 2, "character '時'"),
        ('[scatter]\nper = "day"', 2, "did you mean"),
        ("[practice]\ncut_off = 7", 1, "asks for 7 faulty files, but there are 3 pulls"),
        ("weather = 1", 1, "unknown key 'weather'"),
        ("[pulls", 1, "is not valid TOML"),
    ],
)
def test_errors_name_file_line_and_what_is_allowed(text: str, line: int, words: str) -> None:
    base = '\n[[brakes]]\nbrake = "choi2018-kapton"\n'
    base += "" if "vacuums" in text else '[pulls]\nvacuums = ["40 kPa"]\n'
    if "[pulls]\nr" in text:
        text, base = text + '\nvacuums = ["40 kPa"]', base.split("[pulls]", maxsplit=1)[0]
    with pytest.raises(FileError) as caught:
        parse_spec(text + base, "spec.toml")
    assert words in str(caught.value)
    assert caught.value.line == line or "practice" in words or "faulty" in words


def test_brakes_have_their_own_errors(tmp_path: Path) -> None:
    pulls = '[pulls]\nvacuums = ["40 kPa"]\n'
    for text, words in (
        ("", "brakes: none is given"),
        ("brakes = 3\n", "each after a line"),
        ("[[brakes]]\nscale_factor = 1.0\n", "brakes.brake .* is missing"),
        ('[[brakes]]\nbrake = "choi2018-kapton"\nstiffness = 131\n', "'131 kN/m' or '131 N/mm'"),
    ):
        with pytest.raises(FileError, match=words):
            parse_spec(text + pulls, "x")
    for wrong, words in (
        ((Truth(brake="kapton"),), "did you mean choi2018-kapton"),
        ((Truth(brake="choi2018-kapton"), Truth(brake="choi2018-kapton")), "use different labels"),
        ((Truth(brake="choi2018-kapton", kinetic=0.4),), "cannot exceed static friction"),
        ((Truth(brake="choi2018-kapton", stiffness=200.0),), "snaps on its mount"),
    ):
        with pytest.raises(LayerjamError, match=words):
            made = campaign(replace(SMALL, brakes=wrong))
            write_campaign(made, tmp_path / "d")
        assert not (tmp_path / "d").exists()  # also where only the simulation could tell


@settings(max_examples=60)
@given(st.integers(0, 2**32), st.integers(1, 6))
def test_damaged_specs_end_in_one_sentence(seed: int, cuts: int) -> None:
    rng = np.random.default_rng(seed)
    text = list(format_spec(example_spec()))
    for _ in range(cuts):
        at = int(rng.integers(len(text)))
        text[at : at + int(rng.integers(0, 9))] = rng.choice(list('0-9.e"[]=\n,N kPa#'), 2)
    try:
        campaign(parse_spec("".join(text), "x"))
    except LayerjamError as error:
        assert len(str(error)) < 600


def test_too_much_is_refused() -> None:
    with pytest.raises(QuantityError, match="at most 10000 are allowed"):
        check_spec(replace(SMALL, pulls=Pulls(
            vacuums=tuple(1e3 * n for n in range(1, 91)), repeats=1000)))  # fmt: skip
    with pytest.raises(QuantityError, match="neither brakes to pull nor friction tests"):
        check_spec(replace(SMALL, pulls=Pulls()))
    with pytest.raises(QuantityError, match="samples; 10 to 5000000"):
        campaign(made(SMALL, machine={"sampling_rate": 1e6}, pulls={"speeds": (1e-4,)}))
    with pytest.raises(QuantityError, match="between zero and atmospheric pressure"):
        campaign(made(SMALL, pulls={"vacuums": (110e3,)}))
    with pytest.raises(QuantityError, match="agree to five digits"):
        campaign(made(SMALL, pulls={"vacuums": (50e3, 50000.001)}))
    with pytest.raises(UnknownNameError):
        campaign(replace(SMALL, files=Files(layouts=("excel",))))


# --- the plan and its records


def test_all_vacuums_at_all_speeds_in_order() -> None:
    spec = replace(example_spec(), machine=Faults(warming=2.0))
    made = campaign(spec)
    pulls = [t for t in made.tests if t.kind == "pull"]
    assert len(pulls) == 18 and len(made.tests) == 21
    assert [t.number for t in made.tests] == list(range(21))
    assert {(t.vacuum, t.speed) for t in pulls} == set(
        itertools.product(spec.pulls.vacuums, spec.pulls.speeds)
    )
    assert made.tests[0].warmer == 0 and made.tests[-1].warmer == 2.0
    traces = made.traces()
    assert [t.path for t in traces] == [t.name for t in made.tests]
    assert all(t.facts.synthetic and t.facts.seed == 1 for t in traces)
    assert [len(made.traces(k)) for k in ("pull", "friction")] == [18, 3]


def test_numbers_are_the_seeds_bit_for_bit() -> None:
    first, again, other = (campaign(example_spec(), seed).traces() for seed in (4, 4, 5))
    for a, b, c in zip(first, again, other, strict=True):
        np.testing.assert_array_equal(a.force, b.force)
        assert a.facts.seed == 4 and not np.array_equal(a.force[:50], c.force[:50])


def test_a_pull_does_not_depend_on_the_tests_simulated_with_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole = campaign(example_spec()).traces()
    monkeypatch.setattr(import_module("layerjam.laboratory.campaigns.campaign"), "_CHUNK", 1)
    for a, b in zip(whole, campaign(example_spec()).traces(), strict=True):
        np.testing.assert_allclose(a.force, b.force, rtol=0, atol=1.1e-3)  # one step of the cell


# --- the folder


def folder_of(spec: Spec, folder: Path, **more: Any) -> dict[str, bytes]:
    """The bytes of all files of a campaign."""
    write_campaign(campaign(spec), folder, **more)
    return {p.name: p.read_bytes() for p in sorted(folder.iterdir())}


def test_the_same_folder_from_the_same_spec_and_from_its_own(tmp_path: Path) -> None:
    spec = made(example_spec(), machine={"sampling_rate": 100.0})
    one = folder_of(spec, tmp_path / "a")
    two = folder_of(read_spec(tmp_path / "a" / "spec.toml"), tmp_path / "b")
    for texts in (one, two):
        texts.pop("README.txt")  # its commands name the folder
    assert one == two


def test_every_file_says_that_it_is_synthetic(tmp_path: Path) -> None:
    spec = replace(SMALL, files=Files(layouts=tuple(LAYOUTS)), friction=FrictionTests(repeats=5),
                   pulls=replace(SMALL.pulls, repeats=7))  # fmt: skip
    for name, data in folder_of(spec, tmp_path).items():
        assert b"synthetic" in data.lower()[:500], name
    beside = {p.name for p in tmp_path.glob("*.toml")}
    assert {f"{file_name(c, t)}.toml" for c in [campaign(spec)] for t in c.tests} <= beside


def test_sidecars_hold_what_the_gauge_showed(tmp_path: Path) -> None:
    spec = made(SMALL, machine={"vacuum_error": 2e3})
    made_campaign = campaign(spec)
    written = write_campaign(made_campaign, tmp_path)
    for test, path in zip(made_campaign.tests, written.files, strict=True):
        facts = read_facts(path)
        assert (facts.vacuum, facts.speed, facts.repeat) == (94.5e3, 13e-3, test.repeat)
        assert facts.brake == "choi2018-kapton" and facts.synthetic and facts.seed == 1
    truth = tomllib.loads((tmp_path / "truth.toml").read_text())
    assert [t["true_vacuum"] for t in truth["tests"]] == ["96.5 kPa", "96.5 kPa"]


def test_a_brake_of_ones_own_is_copied_along(tmp_path: Path) -> None:
    text = load("choi2018-ptfe").text.replace("choi2018-ptfe", "mine")
    (tmp_path / "mine.toml").write_text(text)
    (tmp_path / "spec.toml").write_text(
        '[[brakes]]\nbrake = "mine.toml"\n[pulls]\nvacuums = ["80 kPa"]\n[machine]\n'
        'sampling_rate = "50 Hz"\n'
    )
    folder_of(read_spec(tmp_path / "spec.toml"), tmp_path / "a")
    assert (tmp_path / "a" / "brake-mine.toml").read_text() == text
    again = folder_of(read_spec(tmp_path / "a" / "spec.toml"), tmp_path / "b")
    assert again["truth.toml"] == (tmp_path / "a" / "truth.toml").read_bytes()


def test_full_folders_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(FileError, match="is not empty; use --overwrite"):
        write_campaign(campaign(SMALL), tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.txt"]
    assert write_campaign(campaign(SMALL), tmp_path, overwrite=True).strangers == 1
    assert (tmp_path / "thesis.txt").read_text() == "mine"
    assert write_campaign(campaign(SMALL), tmp_path, overwrite=True).strangers == 1
    with pytest.raises(FileError, match="is a file, not a folder"):
        write_campaign(campaign(SMALL), tmp_path / "thesis.txt", overwrite=True)


def test_an_interrupt_leaves_nothing(tmp_path: Path) -> None:
    def stop(what: str, share: float) -> None:
        if share > 0.4:
            raise KeyboardInterrupt

    spec = made(SMALL, pulls={"repeats": 9})
    for folder in (tmp_path / "new", tmp_path / "old"):
        (tmp_path / "old").mkdir(exist_ok=True)
        with pytest.raises(KeyboardInterrupt):
            write_campaign(campaign(spec), folder, progress=stop)
        assert [p.name for p in tmp_path.iterdir()] == ["old"] or folder.name == "new"
        assert not (tmp_path / "new").exists() and not list((tmp_path / "old").iterdir())


# --- through the readers

LANGUAGE_AND_ENCODING = list(itertools.product(LANGUAGES, ("usual", *ENCODINGS)))
READABLE = [
    Form(layout=layout, language=language, encoding=encoding, decimal=".,"[number % 2])
    for layout in LAYOUTS
    for number, (language, encoding) in enumerate(LANGUAGE_AND_ENCODING)
] + [Form(layout=layout) for layout in LAYOUTS]


def possible(form: Form) -> bool:
    """Whether the encoding has the language's letters."""
    try:
        form.check_encoding()
    except QuantityError:
        return False
    return True


@pytest.mark.parametrize(
    ("step", "least"), [(5, 4), pytest.param(1, 20, marks=pytest.mark.slow)], ids=("few", "all")
)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_is_read_back_in_every_language_and_encoding(
    layout: str, step: int, least: int, tmp_path: Path
) -> None:
    spec = made(SMALL, pulls={"repeats": 1}, machine={"sampling_rate": 40.0})
    count = 0
    for form in [f for f in READABLE if f.layout == layout and possible(f)][::step]:
        said = Files(
            layouts=(layout,), language=form.language, encoding=form.encoding, decimal=form.decimal
        )
        one = campaign(replace(spec, files=said))
        (path,) = write_campaign(one, tmp_path, overwrite=True).files
        (truth,), back = one.traces(), read_trace(path)
        np.testing.assert_allclose(back.force, truth.force, rtol=5e-6, atol=6e-6)
        np.testing.assert_allclose(back.elongation, truth.elongation, rtol=5e-6, atol=1e-9)
        np.testing.assert_allclose(back.time, truth.time, rtol=5e-6, atol=1e-6)
        assert back.facts == truth.facts and any("synthetic" in w for w in back.warnings)
        count += 1
        if form.details.fixed:
            break
    assert count == 1 if layout == "own" else count > least


@pytest.mark.parametrize(
    ("brake", "layout"),
    [
        *(("choi2018-kapton", layout) for layout in LAYOUTS),
        ("choi2018-ptfe", "own"),
        *(
            pytest.param("choi2018-ptfe", layout, marks=pytest.mark.slow)
            for layout in LAYOUTS
            if layout != "own"
        ),
    ],
)
def test_the_truth_comes_back(layout: str, brake: str, tmp_path: Path) -> None:
    """Scale factor within 2 % and stiffness within 5 %, at noise of 0.1 % of the peak."""
    peak = {"choi2018-kapton": 176.0, "choi2018-ptfe": 52.0}[brake]
    known = load(brake).brake
    truth = Truth(brake=brake, scale_factor=1.1, stiffness=90e3, kinetic=known.film.kinetic * 1.05)
    spec = Spec(
        brakes=(truth,),
        pulls=Pulls(vacuums=(94.5e3,), speeds=(7e-3, 19e-3), repeats=2),
        friction=FrictionTests(repeats=3, force_noise=1e-3, load_cell_range=10.0),
        machine=Faults(
            sampling_rate=500.0, force_noise=1e-3 * peak, force_step=1e-3, travel_step=1e-7,
            crosshead_start=-2.5e-3, slack=0.2e-3, dropped=1e-3,
        ),
        files=Files(layouts=(layout,)),
    )  # fmt: skip
    files = [str(p) for p in write_campaign(campaign(spec), tmp_path).files]
    mine = tmp_path / "mine.toml"
    found = friction(files[:3], brake=brake, out=mine)
    assert found.kinetic == pytest.approx(known.film.kinetic * 1.05, rel=0.005)
    assert found.static == pytest.approx(known.film.static, rel=0.03)
    result = calibrate(mine, files[3:])
    assert result.scale_factor == pytest.approx(1.1, rel=0.02)
    assert result.stiffness == pytest.approx(90e3, rel=0.05)
    assert not result.refused
    # with the friction of the brake's own file, the product is what is found
    beside = tomllib.loads((tmp_path / "truth.toml").read_text())["brakes"][0]
    plain = calibrate(brake, files[3:])
    assert plain.scale_factor == pytest.approx(beside["scale_factor_with_known_friction"], rel=0.02)


FOUND: dict[str, Callable[[str], bool]] = {
    "cut_off": lambda why: "the last line is cut off" in why,
    "header_only": lambda why: len(why) > 20,  # which words depends on the layout's reader
    "negative_force": lambda why: "the force of largest magnitude is negative" in why,
    "saturated": lambda why: "the load cell was saturated" in why,
    "no_sidecar": lambda why: "its vacuum is not stated" in why,
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_faulty_files_are_named_and_the_others_done(layout: str, tmp_path: Path) -> None:
    spec = replace(
        made(SMALL, pulls={"repeats": 9}),
        files=Files(layouts=(layout,)),
        practice=Practice(**dict.fromkeys(FOUND, 1)),
    )
    one = campaign(spec)
    files = [str(p) for p in write_campaign(one, tmp_path).files]
    answer = calibrate("choi2018-kapton", files)
    faulty = {p: t.practice for p, t in zip(files, one.tests, strict=True) if t.practice}
    assert sorted(faulty.values()) == sorted(FOUND)
    assert set(answer.refused) == set(faulty)
    for path, fault in faulty.items():
        assert FOUND[fault](answer.refused[path]), (fault, answer.refused[path])
    truth = tomllib.loads((tmp_path / "truth.toml").read_text())
    stated = {t["file"]: t["practice_fault"] for t in truth["tests"] if "practice_fault" in t}
    assert stated == {Path(p).name: fault for p, fault in faulty.items()}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_wrong_unit_is_a_thousand_times_the_force(layout: str, tmp_path: Path) -> None:
    spec = replace(SMALL, files=Files(layouts=(layout,)), practice=Practice(wrong_unit=1))
    one = campaign(spec)
    written = write_campaign(one, tmp_path)
    for test, path, truth in zip(one.tests, written.files, one.traces(), strict=True):
        factor = 1000.0 if test.practice else 1.0
        back = read_trace(path)
        np.testing.assert_allclose(back.force, factor * truth.force, rtol=5e-6, atol=6e-3)
    try:
        answer = calibrate("choi2018-kapton", [str(p) for p in written.files])
    except LayerjamError:
        return
    assert answer.refused or not all(c["passed"] for c in answer.checks)


def test_a_machine_that_saturates_is_recognised(tmp_path: Path) -> None:
    spec = made(SMALL, machine={"load_cell_range": 150.0})
    written = write_campaign(campaign(spec), tmp_path)
    for path in written.files:
        with pytest.raises(FileError, match=r"saturated.* 150 N "):
            read_trace(path)


def test_layouts_are_taken_in_turn() -> None:
    spec = replace(made(SMALL, pulls={"repeats": 5}), files=Files(layouts=("own", "mts")))
    one = campaign(spec)
    assert [select_form(one, t).layout for t in one.tests] == ["own", "mts", "own", "mts", "own"]


def test_scatter_shows_in_what_calibrate_finds(tmp_path: Path) -> None:
    spec = replace(made(SMALL, pulls={"repeats": 12}), scatter=Scatter(friction=0.05))
    one = campaign(spec)
    files = write_campaign(one, tmp_path).files
    brake = load("choi2018-kapton").brake
    fits = [fit_pull(pull_features(read_trace(p)), 94.5e3, brake) for p in files]
    values = np.array([f.scale_factor for f in fits]) / brake.scale_factor
    drawn = np.array([t.friction for t in one.tests])
    np.testing.assert_allclose(values, drawn, rtol=5e-3)
