"""`enclosure`, `leak`, `pump-down` and `crash` as a user asks for them, in Python and typed."""

from __future__ import annotations

import json

import numpy as np
import pytest

from cli.conftest import contents
from laboratory.measure.layouts import REAL
from layerjam.brake.commands.force import force as brake_force
from layerjam.brake.device.enclosure import FORCE_UNCERTAINTY
from layerjam.brake.device.load import load
from layerjam.brake.device.spread import rate_enclosure
from layerjam.brake.mechanics.hyperelastic import rubber_stress
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.cli.main import main
from layerjam.core.errors import FileError, LayerjamError, QuantityError
from layerjam.laboratory.commands.calibration import calibrate
from layerjam.laboratory.commands.crash import crash
from layerjam.laboratory.commands.enclosure import enclosure
from layerjam.laboratory.commands.leak import leak
from layerjam.laboratory.commands.pressure_log import parse_temperature
from layerjam.laboratory.commands.pump_down import pump_down
from layerjam.laboratory.identify.logs.leak import pressure as leaked
from layerjam.laboratory.identify.logs.pump_down import pressure as pumped
from layerjam.laboratory.identify.rubber import hyperelastic
from layerjam.workshop.commands.show import show

A = 101325.0


@pytest.fixture
def run(capfd, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")

    def go(*words):
        capfd.readouterr()
        code = main([str(w) for w in words])
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err
        return code, out, err

    return go


def curve(path, modulus=30e3, seed=0, head="Strain (%);Stress (MPa)"):
    strain = np.linspace(0.01, 3, 300)
    stress = hyperelastic.stress("neo-hookean", {"C1": modulus}, strain)
    stress = stress + np.random.default_rng(seed).normal(0, 300, len(strain))
    rows = "".join(f"{e * 100:.4f};{s / 1e6:.8f}\n" for e, s in zip(strain, stress, strict=True))
    path.write_text(f"{head}\n{rows}", encoding="utf-8")
    return path


def table(path, head, *columns):
    rows = "".join(",".join(f"{v:.7g}" for v in row) + "\n" for row in zip(*columns, strict=True))
    path.write_text(head + "\n" + rows, encoding="utf-8")
    return path


def hold(tmp_path, name="hold.csv", head="time [s],vacuum [kPa]", noise=20.0):
    t = np.arange(0, 200, 0.5)
    p = leaked("laminar", t, 7e3, 0.004, A) + np.random.default_rng(1).normal(0, noise, len(t))
    return table(tmp_path / name, head, t, (A - p) / 1e3)


def emptied(tmp_path, name, rate, seed=0):
    t = np.arange(0, 15, 0.02)
    p = np.where(t < 1, A, pumped(np.maximum(t - 1, 0), A, 6e3, rate))
    p = p + np.random.default_rng(seed).normal(0, 50, len(t))
    return table(tmp_path / name, "time [s],p_abs [kPa]", t, p / 1e3)


def impact(tmp_path, name="drop.csv", unit="g"):
    t = np.arange(0, 0.15, 1e-4)
    a = np.where((t > 0.06) & (t < 0.08), 18 * np.sin(np.pi * (t - 0.06) / 0.02), 0.0) + 0.05
    a = a + np.random.default_rng(3).normal(0, 0.05, len(t))
    return table(tmp_path / name, f"t [ms],a [{unit}]", t * 1e3, a)


@pytest.fixture(scope="module")
def sleeve(tmp_path_factory):
    """The result of three specimens, and the brake that was made of it."""
    folder = tmp_path_factory.mktemp("sleeve")
    files = [curve(folder / f"{k}.csv", 30e3 + 500 * k, k) for k in range(3)]
    out = folder / "mine.toml"
    found = enclosure(files, material="ecoflex-00-30", brake="choi2018-kapton", out=out)
    return found, load(out)


def test_the_sleeve_of_repeats(sleeve):
    found, _ = sleeve
    assert found.modulus_100 == pytest.approx(2 * 30.5e3 * 1.75, rel=0.01)
    assert found.modulus_100_sd == pytest.approx(500 * 3.5, rel=0.2)
    assert found.model == "neo-hookean"
    assert found.parameters["C1"] == pytest.approx(30.5e3, rel=0.02)
    assert found.difference == pytest.approx(found.modulus_100 / (10 * 6894.757) - 1, rel=1e-5)
    assert found.specimens == 3 and set(found.models) == set(hyperelastic.PARAMETERS)


def test_fewer_strains_fit_another_range(tmp_path):
    path = curve(tmp_path / "a.csv")
    assert enclosure([path]).strain_range[1] == pytest.approx(3.0)
    assert enclosure([path], fit_to="150 %").strain_range[1] == pytest.approx(1.5, rel=0.01)
    with pytest.raises(LayerjamError, match="20 are needed"):
        enclosure([path], fit_to="5 %")


def test_the_modulus_goes_into_a_brake(tmp_path):
    out = tmp_path / "mine.toml"
    found = enclosure([curve(tmp_path / "a.csv")], brake="choi2018-kapton", out=out)
    made = load(out)
    assert made.brake.enclosure.modulus == found.modulus_100
    assert made.sources["enclosure.modulus"].kind == "measured"
    assert "a.csv (SHA-256 " in made.sources["enclosure.modulus"].text
    assert any("calibrate" in w for w in found.warnings)
    with pytest.raises(FileError, match="exists"):
        enclosure([tmp_path / "a.csv"], brake="choi2018-kapton", out=out)


def test_several_specimens_narrow_the_force_of_the_enclosure(sleeve):
    """The force goes with the root of modulus times friction, which is known within 1.5."""
    found, made = sleeve
    relative = found.modulus_100_sd / found.modulus_100 / 3**0.5
    due = (relative**2 + np.log(1.5) ** 2) ** 0.5 / 2
    assert rate_enclosure(made).enclosure.force_sd == pytest.approx(due, abs=1e-4)
    (tests,) = made.evidence
    assert (tests.command, tests.tests) == ("enclosure", 3)
    assert tests.ranges == {"strain": (0.0, pytest.approx(3.0, rel=0.01))}
    # another modulus belongs to another enclosure, whose force nobody measured
    other = made.with_(enclosure_modulus="200 kPa")
    assert rate_enclosure(other).enclosure.force_sd == FORCE_UNCERTAINTY


def test_a_brake_is_calibrated_with_the_uncertainty_of_its_tested_enclosure(sleeve, tmp_path):
    """The enclosure's line of the budget is the tested one, as if the file stated it."""
    _, made = sleeve
    u = np.linspace(0, 0.03, 4000)
    force = np.asarray(force_at_elongation(u, 60e3, made.brake))
    pulls = [
        table(tmp_path / f"p{k}.csv", "u [m],F [N]", u, force * (1 + 0.01 * k)) for k in (0, 1)
    ]
    tested = calibrate(made, pulls, vacuum="60 kPa")
    sd = rate_enclosure(made).enclosure.force_sd
    stated = calibrate(made.with_(force_uncertainty=sd), pulls, vacuum="60 kPa")
    unknown = calibrate(made.with_(force_uncertainty=0.3), pulls, vacuum="60 kPa")
    ends = [found.intervals["scale_factor"] for found in (tested, stated, unknown)]
    widths = [end["high"] - end["low"] for end in ends]
    assert widths[0] == pytest.approx(widths[1], rel=1e-9)
    assert widths[0] < widths[2]


def test_the_model_goes_into_a_brake_where_it_is_asked_for(tmp_path):
    path = curve(tmp_path / "a.csv")
    once, twice = tmp_path / "once.toml", tmp_path / "twice.toml"
    found = enclosure([path], brake="choi2018-kapton", out=once, hyperelastic=True)
    law = load(once).brake.hyperelastic
    strain = np.linspace(0, law.strain, 30)
    due = hyperelastic.stress(found.model, found.parameters, strain)
    np.testing.assert_allclose(rubber_stress(strain, law), due, rtol=1e-6)
    assert law.strain == found.strain_range[1]
    assert load(once).sources["hyperelastic.strain"].kind == "measured"
    # the same pull, in which the enclosure alone is another
    one, other = (brake_force(b, slip="5 mm", vacuum="20 kPa") for b in ("choi2018-kapton", once))
    assert one.sheet_friction == other.sheet_friction
    assert other.enclosure_force != pytest.approx(one.enclosure_force, rel=1e-3)
    # another test replaces the whole law, and does not leave it beside a new modulus
    with pytest.raises(QuantityError, match="--hyperelastic"):
        enclosure([path], brake=once, out=twice)
    again = enclosure([path], brake=once, out=twice, hyperelastic=True, fit_to="150 %")
    new = load(twice).brake.hyperelastic
    assert new.strain == pytest.approx(1.5, rel=0.01)
    due = hyperelastic.stress(again.model, again.parameters, 1.0)
    assert float(rubber_stress(1.0, new)) == pytest.approx(float(due), rel=1e-6)
    with pytest.raises(QuantityError, match="give brake and out too"):
        enclosure([path], hyperelastic=True)
    with pytest.raises(QuantityError, match="stretched beyond the measured"):
        brake_force(twice, slip=0.06, vacuum=9e4)
    assert any(w.key == "one-modulus" for w in show(once).warnings)


def test_one_bad_file_is_named_and_the_brake_waits(tmp_path):
    good, bad = curve(tmp_path / "a.csv"), tmp_path / "b.csv"
    bad.write_text("nothing,here\n")
    out = tmp_path / "mine.toml"
    found = enclosure([good, bad], brake="choi2018-kapton", out=out)
    assert list(found.refused) == [str(bad)] and not out.exists()
    found = enclosure([good, bad], brake="choi2018-kapton", out=out, partial=True)
    assert out.exists() and found.file == str(out)
    same = tmp_path / "again.csv"
    same.write_bytes(good.read_bytes())
    assert "same measurement" in enclosure([good, same]).refused[str(same)]


@pytest.mark.slow
@pytest.mark.skipif(not (REAL / "silicone_tensile").is_dir(), reason="no real files here")
def test_real_silicones_beside_their_data_sheets():
    files = sorted((REAL / "silicone_tensile").glob("*.csv"))
    found = enclosure(files)
    assert found.modulus_100 is None and any("several materials" in w for w in found.warnings)
    off = {row["material"]: round(100 * row["difference"]) for row in found.files.values()}
    assert off == {
        "dragon-skin-10": -26, "dragon-skin-20": -6, "dragon-skin-30": -26,
        "ecoflex-00-10": -73, "ecoflex-00-30": -58, "ecoflex-00-50": -51,
    }  # fmt: skip


def test_the_leak_of_a_brake_under_vacuum(tmp_path):
    found = leak(hold(tmp_path), volume="7.5 mL", temperature="23 °C")
    assert (found.reading, found.model, found.distinct) == ("vacuum", "laminar", True)
    assert found.rate_low < 0.004 < found.rate_high
    assert found.conductance == pytest.approx(7.5e-6 * 0.004, rel=0.02)
    assert found.leak_rate < 0 and found.side == "under the atmosphere"
    mean = found.mean_pressure
    due = 7.5e-6 * 0.004 * (mean**2 - A**2) / (2 * A)
    assert found.leak_rate_low < due < found.leak_rate_high
    assert found.leak_rate_sccm == pytest.approx(
        found.leak_rate * 273.15 / 296.15 / (101325e-6 / 60)
    )
    assert found.temperature_equivalent > 10


def test_readings_are_stated_or_asked_for(tmp_path):
    plain = hold(tmp_path, head="time [s],pressure [kPa]")
    with pytest.raises(FileError, match="--reading"):
        leak(plain)
    one = leak(plain, reading="vacuum")
    assert one.rate == pytest.approx(leak(hold(tmp_path, "v.csv")).rate)
    assert any("without --volume" in w for w in one.warnings)
    with pytest.raises(LayerjamError, match="unknown reading"):
        leak(plain, reading="relative")
    said = leak(hold(tmp_path, "g.csv", "time [s],p [kPa(g)]"), reading="vacuum")
    assert any("its column states gauge" in w for w in said.warnings)
    with pytest.raises(FileError, match="cannot be read as vacuum"):
        leak(hold(tmp_path, "w.csv", "time [s],p [bar]"), reading="vacuum")


@pytest.mark.parametrize(
    ("text", "kelvin"), [("23 °C", 296.15), ("296 K", 296.0), ("68 °F", 293.15), (300.0, 300.0)]
)
def test_temperatures(text, kelvin):
    assert parse_temperature(text) == pytest.approx(kelvin)


@pytest.mark.parametrize("text", ["23", "23 bar", "warm", "-200 °C", "9999 K", float("nan")])
def test_what_is_no_temperature(text):
    with pytest.raises(QuantityError, match="temperature"):
        parse_temperature(text)


def test_a_pump_down_tells_what_it_can(tmp_path):
    path = emptied(tmp_path, "one.csv", 0.44)
    bare = pump_down(path)
    assert bare.identifiable == "flow/volume" and bare.volume is None and bare.flow is None
    assert bare.rate_low < 0.44 < bare.rate_high
    known = pump_down(path, volume="7.5 mL")
    assert known.flow == pytest.approx(3.3e-6, rel=0.01) and known.volume == 7.5e-6
    other = pump_down(path, flow="3.3 mL/s")
    assert other.volume_low < 7.5e-6 < other.volume_high
    two = emptied(tmp_path, "two.csv", 3.3e-6 / 17.5e-6, seed=2)
    both = pump_down(path, two, added_volume="10 mL")
    assert both.volume_low < 7.5e-6 < both.volume_high
    assert both.flow_low < 3.3e-6 < both.flow_high


def test_a_pump_down_with_compliance(tmp_path):
    t = np.arange(0, 15, 0.02)
    loss = 0.03e-9
    p = pumped(t, A, 6e3, 0.44, loss / 7.5e-6) + np.random.default_rng(5).normal(0, 30, len(t))
    path = table(tmp_path / "soft.csv", "time [s],p_abs [kPa]", t, p / 1e3)
    known = pump_down(path, volume="7.5 mL", compliance="0.03 mL/kPa", start="0 s")
    assert known.flow_low < 0.44 * 7.5e-6 < known.flow_high
    from_flow = pump_down(path, flow="3.3 mL/s", compliance="0.03 mL/kPa", start="0 s")
    assert from_flow.volume == pytest.approx(7.5e-6, rel=0.01)
    fitted = pump_down(path, volume="7.5 mL", compliance="fit", start="0 s")
    assert fitted.compliance == pytest.approx(loss, rel=0.02)
    assert fitted.compliance_ratio_low < loss / 7.5e-6 < fitted.compliance_ratio_high


def test_pump_downs_that_contradict_themselves(tmp_path):
    path = emptied(tmp_path, "one.csv", 0.44)
    for given, words in (
        ({"volume": "7 mL", "flow": "3 mL/s"}, "give only one of them"),
        ({"added_volume": "7 mL"}, "second log"),
        ({"compliance": "1 mL/kPa"}, "requires --volume or --flow"),
        ({"compliance": "1 mL/kPa", "volume": "7 mL"}, "would reduce"),
        ({"start": "5 s", "end": "2 s"}, "is not below"),
    ):
        with pytest.raises(LayerjamError, match=words):
            pump_down(path, **given)


def test_a_crash_in_g_and_in_si(tmp_path):
    one = crash(impact(tmp_path))
    assert one.filtered_peak_g == pytest.approx(18, rel=0.01)
    assert one.velocity_change == pytest.approx(18 * 9.80665 * 0.04 / np.pi, rel=0.01)
    other = crash(impact(tmp_path, "si.csv", "m/s^2"))
    assert other.filtered_peak == pytest.approx(one.filtered_peak_g, rel=1e-6)
    assert crash(tmp_path / "si.csv", range="10 m/s^2").saturated
    assert not crash(tmp_path / "si.csv", sensor_range="250 g").saturated
    assert crash(impact(tmp_path, "h.csv"), hic="15 ms").hic > 0


KEYS = {
    "enclosure": "material specimens modulus_100 modulus_100_sd data_sheet difference "
    "initial_modulus initial_modulus_sd modulus_300 strength strain_at_end model parameters why "
    "model_modulus "
    "strain_range rmse error_at_100 stable models window files understood refused file",
    "leak": "model distinct rate rate_low rate_high time_constant time_constant_low "
    "time_constant_high conductance leak_rate leak_rate_low leak_rate_high leak_rate_sccm "
    "pressure_change_rate mean_pressure side reading atmosphere zero_fitted temperature "
    "temperature_equivalent window samples models understood",
    "pump-down": "rate rate_low rate_high rate_with_volume time_constant volume volume_low "
    "volume_high flow flow_low flow_high ultimate_pressure ultimate_pressure_low "
    "ultimate_pressure_high ultimate_vacuum start_pressure compliance_ratio compliance_ratio_low "
    "compliance_ratio_high compliance rmse identifiable reading atmosphere window samples "
    "understood",
    "crash": "peak peak_g peak_time filtered_peak filtered_peak_g filtered_peak_time filter "
    "velocity_change velocity_change_se duration pulse hic hic_window offset offset_se quiet "
    "sampling saturated samples understood",
}


def make_file(tmp_path, command):
    if command == "enclosure":
        return curve(tmp_path / "a.csv")
    if command == "leak":
        return hold(tmp_path)
    return emptied(tmp_path, "p.csv", 0.44) if command == "pump-down" else impact(tmp_path)


@pytest.mark.parametrize("command", KEYS)
def test_json_is_complete_and_text_fits(run, tmp_path, command):
    path = make_file(tmp_path, command)
    code, out, err = run(command, path, "--json", "--figure", tmp_path / "f.svg")
    assert (code, err) == (0, "") and (tmp_path / "f.svg").stat().st_size > 5000
    found = json.loads(out, parse_constant=pytest.fail)
    judged = {"checks", "verdict", "failed_checks", "accepted"} if "verdict" in found else set()
    assert set(found) == {*KEYS[command].split(), "units", "warnings", *judged}
    assert judged or command == "crash"
    assert set(found["units"]) <= set(found)
    code, out, err = run(command, path)
    assert (code, err) == (0, "") and max(map(len, out.splitlines())) <= 80


@pytest.mark.parametrize("command", KEYS)
@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"", "empty"), (b"\0\1\2\3" * 9, ""), (b"a,b\n1,2\n", "no column"),
        (b"hello\n", ""), (b"time (s),x (kPa)\n0,1\n1,\n2,3\n", ""),
    ],
)  # fmt: skip
def test_bad_files_are_refused_in_one_sentence(run, tmp_path, command, text, words):
    path = tmp_path / "bad.csv"
    path.write_bytes(text)
    before = contents(tmp_path)
    code, out, err = run(command, path, "--figure", tmp_path / "f.svg")
    assert (code, out) == (2, "") and err.startswith("layerjam: ") and err.count("\n") == 1
    assert words in err or words == "no column"
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("command", "words", "says"),
    [
        ("enclosure", ["--area", "18"], "has no unit"),
        ("enclosure", ["--from", "30%", "--to", "10%"], "is not below"),
        ("enclosure", ["--material", "ecoflex-30"], "did you mean"),
        ("enclosure", ["--brake", "choi2018-kapton"], "give both"),
        ("enclosure", ["--columns", "strain:mm,stress:MPa"], "not a unit of strain"),
        ("leak", ["--volume", "3 mm"], "units of m^3"),
        ("leak", ["--volume", "0 mL"], "is not allowed"),
        ("leak", ["--temperature", "23"], "not a temperature"),
        ("leak", ["--from", "190s"], "is not held"),
        ("pump-down", ["--flow", "3 mL"], "m^3/s"),
        ("pump-down", ["--reading", "vacuum"], ""),
        ("crash", ["--filter", "cfc200"], "cfc180"),
        ("crash", ["--filter", "cfc1000", "--sampling", "5 kHz"], "too slow"),
        ("crash", ["--range", "0 g"], "is not allowed"),
        ("crash", ["--before", "1 ks"], "at least 5"),
    ],
)
def test_wrong_input_as_a_user_would_give_it(run, tmp_path, command, words, says):
    code, out, err = run(command, make_file(tmp_path, command), *words)
    if command == "leak" and words[0] == "--from":
        assert code == 0 or "20" in err
        return
    assert (code, out) == (2, ""), err
    assert says in err and err.count("\n") == 1


def test_exit_3_where_some_files_are_refused(run, tmp_path):
    bad = tmp_path / "b.csv"
    bad.write_text("x\n")
    code, out, _ = run("enclosure", curve(tmp_path / "a.csv"), bad)
    assert code == 3 and "refused:" in out
