"""Effects of other packages, as tables [effects.NAME] of a brake file."""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from layerjam.brake.commands.edit import edit
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.device.load import load
from layerjam.brake.kernel.engine import follow_history
from layerjam.brake.kernel.parameters import parameters
from layerjam.brake.mechanics.effects import is_proportional
from layerjam.brake.mechanics.friction import friction_per_contact, sheet_friction
from layerjam.brake.simulate.procedure import simple_pull
from layerjam.brake.simulate.tensile import tensile
from layerjam.core import plugins
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.toml_files import plugin_tables
from layerjam.core.toml_files.source import Source
from layerjam.core.units import quantity, record
from layerjam.interop.fmi import brake_values
from layerjam.laboratory.commands.calibration import calibrate
from layerjam.laboratory.identify.origin import describe_origin
from layerjam.laws import brake_force, vacuum_for_force

PLUGIN = Path(__file__).parents[3] / "examples" / "plugin" / "src"
CODE = """
from layerjam.brake.device.effect import Effect
from layerjam.core.units import quantity, record

@record
class Frost(Effect):
    depth: float = quantity("m", "thickness of the frost", hi=1e-3)
    half: float = quantity("Pa", "vacuum of half the effect", default=1e4)

    def friction_factor(self, vacuum, brake):
        return 1 - 0.5 * self.depth / 1e-3 * self.half / (self.half + vacuum)

Number = float
"""
POINTS = """[layerjam.effects]
humidity = layerjam_example.humidity:Humidity
frost = frosty:Frost
broken = frosty:Missing
number = frosty:Number
"""
KAPTON = load("choi2018-kapton")
WET = """
[effects.humidity]   # of the room
humidity = { value = 0.8, kind = "measured", source = "hygrometer" }
slope = 0.4
"""


def clear_caches() -> None:
    plugins.list_plugins.cache_clear()
    for function in (plugin_tables.load_table_class, plugin_tables._find_name):
        function.cache_clear()


@pytest.fixture(scope="module", autouse=True)
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Two installed packages with effects."""
    folder = tmp_path_factory.mktemp("site")
    info = folder / "frosty-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: frosty\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(POINTS)
    (folder / "frosty.py").write_text(CODE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [str(folder), str(PLUGIN), *sys.path])
        clear_caches()
        yield
    clear_caches()


def read(more: str, text: str = KAPTON.text) -> BrakeFile:
    return BrakeFile.read(text + more, "mine.toml")


def friction(brake: Brake, vacuum: float = 8e4) -> float:
    return float(friction_per_contact(vacuum, brake))


def test_a_table_sets_an_effect_with_units_and_sources() -> None:
    wet = read(WET)
    assert friction(wet.brake) / friction(KAPTON.brake) == pytest.approx(1 + 0.4 * 0.3, rel=1e-14)
    assert wet.sources["effects.humidity.humidity"].text == "hygrometer"
    assert "effects.humidity.slope          0.4" in str(wet)
    frost = read('\n[effects.frost]\ndepth = "0.2 mm"\n').brake
    ratio = friction(frost, 3e4) / friction(KAPTON.brake, 3e4)
    assert ratio == pytest.approx(1 - 0.1 * 0.25, rel=1e-14)
    assert is_proportional(wet.brake) and not is_proportional(frost)


def test_two_effects_multiply_in_the_order_of_the_file() -> None:
    both = read(WET + '\n[effects.frost]\ndepth = "1 mm"\n').brake
    assert [type(effect).__name__ for effect in both.effects] == ["Humidity", "Frost"]
    ratio = friction(both, 1e4) / friction(KAPTON.brake, 1e4)
    assert ratio == pytest.approx(1.12 * 0.75, rel=1e-14)
    force = brake_force(0.01, 4e4, both)
    assert vacuum_for_force(force, 0.01, both) == pytest.approx(4e4, rel=1e-9)


def test_effects_survive_every_way_of_writing_a_file() -> None:
    wet = read(WET)
    assert BrakeFile.read(wet.render("again"), "again").brake == wet.brake
    assert "# of the room" in wet.with_(width="14 mm").text
    assert wet.with_(width="14 mm").brake.effects == wet.brake.effects
    fitted = updated_text(wet, "fitted", {"scale_factor": (0.9, Source(kind="measured"))})
    assert BrakeFile.read(fitted, "fitted").brake.effects == wet.brake.effects
    assert BrakeFile.from_record(wet.brake, "plain").brake == wet.brake
    assert wet.brake.with_(width="14 mm").effects == wet.brake.effects


def test_numbers_of_effects_change_by_name_and_by_path() -> None:
    wet = read(WET)
    dry = wet.with_(effects_humidity_humidity=0.1)
    assert dry.brake.effects[0].humidity == 0.1 and dry.brake.effects[0].slope == 0.4
    assert wet.brake.with_(effects_humidity_humidity=0.1) == dry.brake
    new = KAPTON.brake.with_(effects_frost_depth="0.1 mm")
    assert new == KAPTON.with_(effects_frost_depth="0.1 mm").brake
    assert new.effects[0].depth == 1e-4
    typed = edit(wet, {"effects.humidity.slope": "0.2"}, kind="measured", source="chamber")
    source = typed.record.sources["effects.humidity.slope"]
    assert (source.text, typed.record.brake.effects[0].slope) == ("chamber", 0.2)
    by_hand = edit(KAPTON, {"effects.frost.depth": "1 mm"}).record
    assert "effects.frost.depth" in describe_origin(by_hand).sentence
    with pytest.raises(QuantityError, match="humidity is missing"):
        KAPTON.brake.with_(effects_humidity_slope=0.2)


@pytest.mark.parametrize(
    ("lines", "error"),
    [
        ("[effects.humidty]\nslope = 1", r"line \d+: effects.humidty: no installed package provides"
         r" it \(installed: broken, frost, humidity, number\); install the one that has 'humidty'"),
        ('[effects.frost]\ndepth = "3 kPa"', r"effects.frost.depth: '3 kPa' is not in units of l"),
        ('[effects.frost]\ndepth = "3 mm"', r"effects.frost.depth: 3 mm is not allowed; thickness"),
        ("[effects.frost]\ndepth = 3", r"effects.frost.depth: 3 has no unit"),
        ('[effects.frost]\nhalf = "3 Pa"', r"effects.frost.depth \(thickness of the frost\)"),
        ('[effects.frost]\ndeep = "3 Pa"', r"'effects.frost.deep'; did you mean effects.frost."),
        ("[effects]\nfrost = 1", r"effects must be tables, each after a line \[effects.NAME\]"),
        ("[effects.speed_law]\npower = 1", "speed_law is built in; write it outside"),
        ("[effects.broken]", "effects.broken: its package cannot be loaded: .*Missing"),
        ("[effects.number]", "effects.number: <class 'float'> of layerjam.effects is not a class"),
    ],
)  # fmt: skip
def test_a_wrong_table_is_refused_with_its_line(lines: str, error: str) -> None:
    count = KAPTON.text.count("\n")
    with pytest.raises(FileError, match=error) as caught:
        read("\n" + lines)
    assert caught.value.line is not None and caught.value.line > count


def test_the_kernel_has_only_effects_that_it_can_apply() -> None:
    plain, wet = KAPTON.brake, read(WET)
    assert parameters(wet).contact == pytest.approx(1.12 * parameters(plain).contact, rel=1e-14)
    frost = read('[effects.frost]\ndepth = "0.2 mm"\n')
    with pytest.raises(QuantityError, match="effects.frost: the exported law does not have this"):
        parameters(frost)
    with pytest.raises(QuantityError, match="effects.humidity: an FMU does not have this effect"):
        brake_values(wet)


@pytest.mark.slow
def test_a_history_with_another_effect_is_followed_by_the_law() -> None:
    plain = KAPTON.brake
    frost = read('[effects.frost]\ndepth = "0.2 mm"\n')
    elongation = np.linspace(0.0, 0.01, 40)
    vacuum = np.full(40, 3e4)
    cycle, engine = follow_history(elongation, vacuum, frost.brake)
    assert engine == "law"
    stiffer = plain.with_(kinetic=plain.film.kinetic * (1 - 0.1 * 0.25))
    equal = follow_history(elongation, vacuum, stiffer)[0]
    assert cycle.force == pytest.approx(equal.force, rel=1e-9)


def test_the_page_of_entry_points_is_read_only_for_effects(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(group: str) -> None:
        raise AssertionError(group)

    monkeypatch.setattr(plugin_tables, "list_plugins", fail)
    plain = BrakeFile.read(KAPTON.text.replace('name = "', 'name = "own-'), "own")
    assert plain.with_(width="14 mm").brake.with_(width="13 mm") == plain.brake
    assert BrakeFile.read(plain.render("own"), "own").brake == plain.brake


def test_jax_traces_the_numbers_of_an_effect_and_not_its_answers() -> None:
    import jax

    from layerjam.jax import double_precision

    wet, frost = read(WET).brake, read('[effects.frost]\ndepth = "0.2 mm"\n').brake
    with double_precision():
        for brake in (wet, frost):
            slope = jax.grad(lambda b: brake_force(0.02, 6e4, b))(brake)
            assert slope.scale_factor == pytest.approx(
                float(sheet_friction(0.02, 6e4, brake)) / 0.875, rel=1e-12
            )
        by_slope = jax.grad(lambda b: brake_force(0.02, 6e4, b))(wet).effects[0].slope
    plain = float(sheet_friction(0.02, 6e4, KAPTON.brake))
    assert by_slope == pytest.approx(plain * (0.8 - 0.5), rel=1e-12)


def test_a_class_of_records_defined_after_jax_was_imported_is_a_pytree() -> None:
    import jax

    import layerjam.jax  # noqa: F401

    @record
    class Frost:
        depth: float = quantity("m", "thickness of the frost", hi=1e-3)

    doubled = jax.tree.map(lambda leaf: 2 * leaf, Frost(depth=2e-4))
    assert doubled == Frost(depth=4e-4)


@pytest.mark.slow
def test_a_calibration_finds_the_scale_factor_without_the_effect(tmp_path: Path) -> None:
    wet, files = read(WET), []
    for vacuum in (40e3, 60e3, 80e3):
        files.append(tmp_path / f"{vacuum:.0f}.csv")
        tensile(wet, simple_pull(vacuum, 0.013, 0.035)).to_csv(files[-1])
    for depth in ("exact", "curves"):
        own = tmp_path / f"{depth}.toml"
        made = calibrate(wet, files, depth=depth, out=own)
        assert made.scale_factor == pytest.approx(0.875, rel=1e-3)
        assert load(own).brake.effects == wet.brake.effects
