"""Units and labels that users bring along: pint, astropy, xarray, pandas, Matplotlib."""

from __future__ import annotations

import copy
import json
import pickle
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jax
import numpy as np
import pandas
import pint
import pytest
import xarray
from matplotlib import pyplot

import layerjam as lj
from layerjam import laws
from layerjam.core.errors import ArgumentError, FileError, LayerjamError, QuantityError

KAPTON = "choi2018-kapton"
ureg = pint.UnitRegistry()


def by_hand(slip: float, vacuum: float) -> float:
    """Force of the sliding Kapton brake [N], eqs. 4, 5 and 7 typed in."""
    sheets = 0.875 * 0.24 * vacuum * 10 * 0.013 * (0.068 - slip)
    return float(sheets + lj.force(KAPTON, slip=slip, vacuum=vacuum).enclosure_force)


def test_pint_quantities_of_any_registry_are_converted() -> None:
    wanted = by_hand(0.02, 50e3)
    other = pint.UnitRegistry()
    for slip, vacuum in (
        (20 * ureg.mm, 50 * ureg.kPa),
        (2 * other.cm, 0.5 * other.bar),
        (0.02, np.float64(50e3)),
        ("20 mm", ureg.Quantity(50e3, "N/m**2")),
    ):
        assert lj.force(KAPTON, slip=slip, vacuum=vacuum).force == pytest.approx(wanted, rel=1e-12)
    stop = lj.drop(KAPTON, mass=1000 * ureg.g, speed=250 * ureg.cm / ureg.s, vacuum=94.5 * ureg.kPa)
    assert stop.peak_force == lj.drop(KAPTON, mass=1, speed=2.5, vacuum=94.5e3).peak_force


class Astropy:
    """The part of an astropy quantity that is read: 50 kPa."""

    unit = "kPa"
    value = 50.0

    def to_value(self, unit: str) -> float:
        return {"Pa": 50e3}[unit]

    def to(self, unit: str) -> Any:
        return SimpleNamespace(value=self.to_value(unit))


def test_other_objects_with_a_unit_are_converted_or_refused() -> None:
    assert lj.force(KAPTON, slip=0.02, vacuum=Astropy()).force == pytest.approx(
        by_hand(0.02, 50e3), rel=1e-12
    )
    with pytest.raises(QuantityError, match="slip: .*Astropy object.* cannot be converted to m"):
        lj.force(KAPTON, slip=Astropy(), vacuum=5e4)
    with pytest.raises(QuantityError, match="vacuum: 50 kilogram cannot be converted to Pa"):
        lj.force(KAPTON, slip=0.02, vacuum=50 * ureg.kg)
    with pytest.raises(QuantityError, match="vacuum: SimpleNamespace with unit 'kPa' is not under"):
        lj.force(KAPTON, slip=0.02, vacuum=SimpleNamespace(unit="kPa", number=50))


def test_laws_refuse_what_carries_a_unit() -> None:
    brake = lj.load(KAPTON).brake
    with pytest.raises(QuantityError, match="laws take numbers in SI units, not .50 kilopascal"):
        laws.brake_force(0.02, 50 * ureg.kPa, brake)


def test_lists_of_text_are_arrays() -> None:
    force = lj.force(KAPTON, slip=["10 mm", "2 cm"], vacuum="50 kPa").force
    assert force == pytest.approx([by_hand(0.01, 5e4), by_hand(0.02, 5e4)], rel=1e-12)
    force = lj.force(KAPTON, slip=[10 * ureg.mm, 0.02], vacuum=[[5e4], [6e4]]).force
    assert np.shape(force) == (2, 2)
    with pytest.raises(QuantityError, match="slip: '20' has no unit"):
        lj.force(KAPTON, slip=["10 mm", "20"], vacuum="50 kPa")


def test_labelled_arrays_broadcast_by_name_and_come_back_labelled() -> None:
    slip = xarray.DataArray([10.0, 20.0, 30.0], dims="slip", attrs={"units": "mm"})
    vacuum = xarray.DataArray([5e4, 9e4], dims="level", coords={"level": ["half", "full"]})
    result = lj.force(KAPTON, slip=slip, vacuum=vacuum)
    force = result.force
    assert isinstance(force, xarray.DataArray) and force.dims == ("slip", "level")
    assert force.attrs["units"] == "N"
    for x in (0.01, 0.02, 0.03):
        for level, pressure in (("half", 5e4), ("full", 9e4)):
            one = force.sel(slip=x, level=level).item()
            assert one == pytest.approx(by_hand(x, pressure), rel=1e-12)
    swapped = lj.force(KAPTON, slip=slip, vacuum=vacuum.rename(level="slip2")).to_xarray()
    assert swapped.force.dims == ("slip", "slip2")
    frame = result.to_frame()
    assert list(frame.columns[:2]) == ["slip", "vacuum"] and len(frame) == 6
    assert frame.attrs["units"]["vacuum"] == "Pa"


def test_labels_that_do_not_fit_are_refused() -> None:
    slip = xarray.DataArray([0.01, 0.02], dims="x", coords={"x": [1, 2]})
    with pytest.raises(QuantityError, match="vacuum: has no named dimensions, but slip has"):
        lj.force(KAPTON, slip=slip, vacuum=[1e4, 2e4])
    with pytest.raises(QuantityError, match="slip: coordinates of the arrays differ"):
        moved = xarray.DataArray([1e4, 2e4], dims="x", coords={"x": [2, 3]})
        lj.force(KAPTON, slip=slip, vacuum=moved)
    with pytest.raises(
        QuantityError, match="slip: its attribute units, 'kg', cannot be converted to m"
    ):
        lj.force(KAPTON, slip=slip.assign_attrs(units="kg"), vacuum=1e4)
    with pytest.raises(QuantityError, match=r"do not broadcast: slip \(2,\) and vacuum \(3,\)"):
        lj.force(KAPTON, slip=[0.01, 0.02], vacuum=[1e4, 2e4, 3e4])


def test_a_coordinate_with_the_name_of_an_input_is_in_si() -> None:
    """Millimetres under the unit m would be a silent wrong number."""
    at = [10.0, 20.0]
    slip = xarray.DataArray(at, dims="slip", coords={"slip": at}, attrs={"units": "mm"})
    result = lj.force(KAPTON, slip=slip, vacuum=5e4)
    for labelled in (result.force, result.to_xarray()):
        assert labelled.slip.values.tolist() == [0.01, 0.02]
        assert labelled.slip.attrs["units"] == "m"
        assert labelled.vacuum.item() == 5e4 and labelled.vacuum.attrs["units"] == "Pa"
    assert result.to_frame().slip.tolist() == [0.01, 0.02]


def test_labelled_results_are_written_and_compared(tmp_path: Path) -> None:
    force = xarray.DataArray([50.0, 300.0], dims="force")
    answer = lj.vacuum(KAPTON, slip=0.02, force=force)
    assert answer.exit_code == 1 and answer.feasible.values.tolist() == [True, False]
    saved = json.loads(answer.save(tmp_path / "answer.json").read_text("utf-8"))
    plain = lj.vacuum(KAPTON, slip=0.02, force=[50.0, 300.0])
    assert saved["vacuum"] == [pytest.approx(float(plain.vacuum[0]), rel=1e-14), None]
    assert answer == lj.vacuum(KAPTON, slip=0.02, force=force)
    assert pickle.loads(pickle.dumps(answer)) == answer


def test_plain_arrays_keep_their_inputs() -> None:
    slip, vacuum = np.linspace(0, 0.05, 5), np.array([[2e4], [9e4]])
    result = lj.force(KAPTON, slip=slip, vacuum=vacuum)
    data = result.to_xarray()
    assert dict(data.sizes) == {"vacuum": 2, "slip": 5}
    assert data.force.sel(slip=0.0, vacuum=9e4).item() == pytest.approx(by_hand(0, 9e4), rel=1e-12)
    assert data.slip.attrs["units"] == "m"
    frame = result.to_frame()
    assert frame.slip.tolist() == [*slip, *slip] and frame.vacuum.nunique() == 2
    together = lj.force(KAPTON, slip=slip, vacuum=np.linspace(1e4, 9e4, 5)).to_xarray()
    assert together.force.dims == ("case_0",) and together.vacuum.dims == ("case_0",)


def test_an_array_of_answers_says_which_of_them_are_possible() -> None:
    answer = lj.vacuum(KAPTON, slip=0.02, force=[50, 100, 300])
    assert answer.feasible.tolist() == [True, True, False] and "143" in answer.reason
    assert np.isnan(answer.vacuum[2]) and answer.exit_code == 1
    text = str(answer)
    assert "nan" not in text and "vacuum [kPa]" in text
    assert [row.split()[-1] for row in text.splitlines() if row.strip().startswith("20")] == [
        "True",
        "True",
        "False",
    ]
    many = str(lj.force(KAPTON, slip=np.linspace(0, 0.05, 500), vacuum=5e4))
    assert "…" in many and len(many.splitlines()) < 20


def test_a_figure_is_drawn_into_the_users_axes() -> None:
    figure, (left, right) = pyplot.subplots(1, 2)
    slip = np.linspace(0, 0.06, 30)[:, None]
    result = lj.force(KAPTON, slip=slip, vacuum=np.array([2e4, 9e4]))
    assert result.plot(ax=left) is figure
    assert [len(line.get_xdata()) for line in left.lines] == [30, 30] and not right.lines
    assert left.lines[1].get_ydata()[0] == pytest.approx(by_hand(0, 9e4), rel=1e-12)
    assert left.lines[1].get_xdata()[-1] == pytest.approx(60)  # mm
    lj.force(KAPTON, slip=0.02, vacuum=5e4).plot(ax=right)
    assert right.get_xlabel() == "sheet slip [mm]"
    with pytest.raises(LayerjamError, match=r"ax: 1 given, but this figure needs \d axes"):
        lj.show(KAPTON).plot(ax=left)
    pyplot.close(figure)
    # inputs that vary together share the axis; one alone has a figure too
    paired = lj.force(KAPTON, slip=[0.01, 0.02, 0.03], vacuum=[1e4, 2e4, 3e4])
    assert [curve.name for curve in paired.grid.panes("force", paired.force, "N")[0].curves] == [""]
    assert lj.force(KAPTON, slip=[0.02], vacuum=5e4).plot() is not None


def pulled(vacuum: float = 67e3) -> pandas.DataFrame:
    """A pull of the Kapton brake with noise of 0.3 N, as a test machine's columns."""
    frame = lj.tensile(KAPTON, travel="20 mm", speed="5 mm/s", vacuum=vacuum).to_frame()
    noise = np.random.default_rng(1).normal(0, 0.3, len(frame))
    load = frame.force + noise
    return pandas.DataFrame({"Extension [mm]": frame.elongation * 1e3, "Load [N]": load})


def test_a_data_frame_is_a_measurement() -> None:
    frame = pulled()
    found = lj.calibrate(KAPTON, frame, vacuum="67 kPa")
    # the brake's own factor, which the pull was computed with
    own = lj.load(KAPTON).brake.scale_factor
    assert found.scale_factor == pytest.approx(own, rel=0.005)
    assert found.understood["<DataFrame>/1"][0].startswith("elongation is the column 'Extension'")
    frame.attrs["vacuum"] = 67 * ureg.kPa
    assert lj.calibrate(KAPTON, [frame]).scale_factor == found.scale_factor
    bare = frame.set_axis(["a", "b"], axis=1)
    mapped = lj.calibrate(KAPTON, bare, column={"elongation:mm": "a", "force:N": "b"})
    assert mapped.scale_factor == found.scale_factor
    with pytest.raises(FileError, match="<DataFrame>/1"):
        lj.calibrate(KAPTON, bare, vacuum="67 kPa")
    frame.attrs["vacuum"] = "6700 kPa"
    with pytest.raises(QuantityError, match="vacuum: 6.7 MPa is not allowed"):
        lj.calibrate(KAPTON, frame)


def test_names_that_a_function_does_not_have() -> None:
    with pytest.raises(ArgumentError, match=r"force\(\) has no parameter 'vaccum'; did you mean v"):
        lj.force(KAPTON, slip=0.02, vaccum=5e4)
    with pytest.raises(
        TypeError, match=r"force\(\) needs vacuum \(Vacuum, atmospheric pressure minus"
    ):
        lj.force(KAPTON, slip=0.02)
    with pytest.raises(
        ArgumentError, match="has no parameter 'zzz'; its parameters are brake, slip"
    ):
        lj.force(KAPTON, slip=0.02, vacuum=5e4, zzz=1)


def test_derivatives_with_respect_to_a_brake() -> None:
    brake = lj.load(KAPTON).brake
    with jax.enable_x64(True):
        slope = jax.grad(lambda one: laws.brake_force(0.02, 5e4, one))(brake)
        of_friction = jax.grad(
            lambda value: laws.brake_force(0.02, 5e4, brake.with_(kinetic=value))
        )(0.24)
    # eq. 4: force over width, friction and number of interfaces is linear
    sheets = 0.875 * 0.24 * 5e4 * 10 * 0.013 * 0.048
    assert float(slope.film.kinetic) == pytest.approx(sheets / 0.24, rel=1e-12)
    assert float(slope.sheets.count) == pytest.approx(sheets / 10, rel=1e-12)
    assert float(of_friction) == pytest.approx(sheets / 0.24, rel=1e-12)
    assert jax.tree.map(float, slope).sheets.overlap == pytest.approx(sheets / 0.048, rel=1e-12)


def test_representations_are_short_and_copies_are_equal() -> None:
    results = [
        lj.force(KAPTON, slip=np.linspace(0, 0.06, 900), vacuum=5e4),
        lj.tensile(KAPTON, travel="20 mm", speed="5 mm/s", vacuum="67 kPa"),
        lj.drop(KAPTON, mass=1, speed=2.5, vacuum=94.5e3),
        lj.calibrate(KAPTON, pulled(), vacuum="67 kPa"),
    ]
    for result in results:
        assert len(repr(result.record)) <= 300
        assert len(repr(result)) < 4000
        again = pickle.loads(pickle.dumps(result))
        assert again == result and hash(again) == hash(result) and copy.copy(result) == result
    assert results[1] != results[2]
    assert lj.force(KAPTON, slip=0.02, vacuum=5e4) != lj.force(KAPTON, slip=0.02, vacuum=6e4)
    text = str(lj.load(KAPTON))
    assert text.startswith("brake Choi 2018, Kapton\n") and "sheets.width" in text
    assert "13 mm" in text and len(text.splitlines()) < 60
    assert "<td>13 mm</td>" in lj.load(KAPTON)._repr_html_()
