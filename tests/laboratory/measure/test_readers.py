"""Each format, each encoding and each language gives the same curve, exactly."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from laboratory.measure.layouts import LAYOUTS, REAL, curve, encoded, rows
from layerjam.core.errors import FileError, LayerjamError
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.column_names import find_role, split_unit
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.measure.readers.unit_words import unit_role
from layerjam.laboratory.measure.trace import Trace

FORMAT = {"testxpert": "Zwick testXpert", "own": "layerjam CSV", "bluehill": "Instron Bluehill"}


def read(tmp_path: Path, data: bytes | str, name: str = "x.csv", **options) -> Trace:
    path = tmp_path / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_trace(path, ReadingOptions(**options) if options else None)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_gives_the_curve(layout: str, tmp_path: Path) -> None:
    trace = read(tmp_path, encoded(layout))
    time, travel, force = (np.array(c) for c in curve())
    digits = 1e-9 if layout == "own" else 6e-5
    assert trace.format == FORMAT.get(layout, "table of columns")
    np.testing.assert_allclose(trace.time, time, atol=6e-5, rtol=0)
    np.testing.assert_allclose(trace.elongation, travel / 1000, atol=6e-8, rtol=0)
    # The TRA layout keeps six digits.
    np.testing.assert_allclose(trace.force, force, atol=max(digits, 6e-5), rtol=5e-6)
    assert len(trace.understood) == 3 and len(trace) == 60
    assert trace.travel[0] == 0 and trace.warnings == ()


@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
def test_line_ends(line_end: str, tmp_path: Path) -> None:
    text = line_end.join(["Time (s),Displacement (mm),Force (N)", *rows(), ""])
    assert len(read(tmp_path, text)) == 60


def test_numbers_are_exact(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    cells = [repr(x) for x in np.sort(rng.uniform(0, 900, 4000)).tolist()]
    cells += [f"{x:.19f}" for x in (901.1, 902.30000000000000001, 903.7)]
    cells += ["904.4503599627370495", "905.", "9.06e2", "+907.25", "908.00000000000011368683772"]
    text = "Displacement [m],Force [N]\n" + "".join(f"{float(c) / 1e3!r},{c}\n" for c in cells)
    np.testing.assert_array_equal(read(tmp_path, text).force, [float(c) for c in cells])
    comma = text.replace(",", ";").replace(".", ",")
    np.testing.assert_array_equal(read(tmp_path, comma).force, [float(c) for c in cells])
    quoted = "\n".join(
        ",".join(f'"{c}"' for c in line.split(";")) for line in comma.split("\n")[1:-1]
    )
    quoted = '"Displacement","Force"\n"(m)","(N)"\n' + quoted + "\n"
    np.testing.assert_array_equal(read(tmp_path, quoted).force, [float(c) for c in cells])


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        *[("N", 1), ("kN", 1000), ("KN", 1000), ("mN", 1e-3), ("Newton", 1)],
        *[("gf", 9.80665e-3), ("kgf", 9.80665), ("lbf", 4.4482216152605)],
    ],
)
def test_force_units(unit: str, factor: float, tmp_path: Path) -> None:
    text = "\n".join([f"Time (s),Extension (mm),Load ({unit})", *rows(), ""])
    trace = read(tmp_path, text)
    written = np.array([float(r.split(",")[2]) for r in rows()])
    np.testing.assert_allclose(trace.force, written * factor, rtol=1e-14)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("mm", 1e-3), ("m", 1.0), ("in", 0.0254), ("µm", 1e-6), ("cm", 0.01), ("inch", 0.0254)],
)
def test_length_units(unit: str, factor: float, tmp_path: Path) -> None:
    text = "\n".join([f"Time (s),Extension ({unit}),Load (N)", *rows(), ""])
    written = np.array([float(r.split(",")[1]) for r in rows()])
    np.testing.assert_allclose(read(tmp_path, text).elongation, written * factor, rtol=1e-15)


def test_time_units_and_a_file_without_time(tmp_path: Path) -> None:
    text = "\n".join(["Load (N),Time (min),Extension (mm)"]
                     + [",".join(np.roll(r.split(","), 1)) for r in rows()] + [""])  # fmt: skip
    assert read(tmp_path, text).time[10] == pytest.approx(6.0)
    bare = "\n".join(["Extension (mm),Load (N)", *(r.split(",", 1)[1] for r in rows()), ""])
    assert read(tmp_path, bare).time is None


HEADS = {
    "names and a unit row": "Time,Extension,Load\n(s),(mm),(N)",
    "square brackets": "Time [s],Extension [mm],Load [N]",
    "slashes": "Zeit / s,Weg / mm,Kraft / N",
    "German words": "Zeit in s,Weg in mm,Kraft in N",
    "French": "Temps (s),Déplacement (mm),Charge (N)",
    "Spanish": "Tiempo (s),Desplazamiento (mm),Fuerza (N)",
    "units alone": "Kolumna 1 (s),Kolumna 2 (mm),Kolumna 3 (N)",
    "a time under another name": "Extension (s),Weg (mm),Kraft (N)",
    "plain units below": '"Zeit","Weg","Kraft"\n"s","mm","N"',
}


@pytest.mark.parametrize("head", HEADS)
def test_headers(head: str, tmp_path: Path) -> None:
    trace = read(tmp_path, "\n".join([HEADS[head], *rows(), ""]))
    assert trace.force.max() > 99 and trace.elongation[-1] == pytest.approx(7.67e-3)
    assert trace.time[-1] == pytest.approx(0.59)


def test_among_several_lengths_the_name_decides_and_the_trace_says_so(tmp_path: Path) -> None:
    body = [f"{r},{i}" for i, r in enumerate(rows())]
    head = "Time (s),Standard travel (mm),Standard force (N),Crosshead absolute (mm)"
    trace = read(tmp_path, "\n".join([head, *body, ""]))
    said = "elongation is the column 'Standard travel' in mm, not 'Crosshead absolute'"
    assert said in trace.understood
    other = read(tmp_path, "\n".join([head, *body, ""]),
                 column=["elongation=crosshead absolute"])  # fmt: skip
    assert other.elongation[5] == 0.005
    swapped = head.replace("Standard travel", "Extensometer")
    assert read(tmp_path, "\n".join([swapped, *body, ""])).elongation[5] == 0.005


def test_torque_strain_and_speed_are_not_taken(tmp_path: Path) -> None:
    body = [f"{r},5,6,7" for r in rows()]
    head = "Time (s),Extension (mm),Load (N),Torque (N·m),Speed (mm/min),Strain (%)"
    assert read(tmp_path, "\n".join([head, *body, ""])).force.max() > 99


def test_columns_nobody_needs_may_hold_anything(tmp_path: Path) -> None:
    words = ["", "n/a", "True", "****", "inf"]
    body = [f"{r},{words[i % 5]}" for i, r in enumerate(rows())]
    trace = read(tmp_path, "\n".join(["Time (s),Extension (mm),Load (N),AVE2 (%)", *body, ""]))
    assert trace.force[0] == float(rows()[0].split(",")[2])


def test_blank_lines_blanks_and_trailing_separators(tmp_path: Path) -> None:
    body = [f" {r.replace(',', ' , ')} ,," for r in rows()]
    body.insert(7, "")
    body.insert(20, ",,,")
    body.insert(30, "   ")
    trace = read(tmp_path, "\n".join(["", "Time (s),Extension (mm),Load (N),", "", *body, "", ""]))
    assert len(trace) == 60


def test_thousands(tmp_path: Path) -> None:
    force = [1234.5 + 0.25 * i + 300 * (i > 40) for i in range(60)]
    head = '"Extension","Load"\n"(mm)","(N)"\n'
    english = "".join(f'"{0.1 * i:.3f}","{f:,.2f}"\n' for i, f in enumerate(force))
    for text in (english, english.translate(str.maketrans(",.", ".,")).replace('"."', '","')):
        np.testing.assert_array_equal(read(tmp_path, head + text).force, force)
    spaced = head + "".join(f'"{0.1 * i:.3f}","{f:,.2f}"\n'.replace(",", "\u00a0").replace(
        '"\u00a0"', '","') for i, f in enumerate(force))  # fmt: skip
    np.testing.assert_array_equal(read(tmp_path, spaced).force, force)


def test_thousands_only_late_in_the_file(tmp_path: Path) -> None:
    force = [0.5 * i + (5000 if 3000 < i < 3010 else 0) for i in range(6000)]
    text = '"Extension","Load"\n"(mm)","(N)"\n'
    text += "".join(f'"{0.01 * i:.3f}","{f:,.1f}"\n' for i, f in enumerate(force))
    np.testing.assert_array_equal(read(tmp_path, text).force, force)


def test_ambiguous_signs_are_asked_for(tmp_path: Path) -> None:
    text = "Extension (mm);Load (N)\n"
    text += "".join(f"{i}.{i % 7}25;{i * 2}.125\n" for i in range(1, 60))
    with pytest.raises(FileError, match="does not show whether '.' is the decimal sign"):
        read(tmp_path, text)
    assert read(tmp_path, text, decimal=".").force[0] == 2.125
    assert read(tmp_path, text, decimal=",").force[0] == 2125.0


def test_sign_is_asked_for_and_turned(tmp_path: Path) -> None:
    text = "\n".join(["Extension (mm),Load (N)"]
                     + [f"{x},{-f}" for _, x, f in zip(*curve(), strict=True)] + [""])  # fmt: skip
    with pytest.raises(FileError, match="of largest magnitude is negative"):
        read(tmp_path, text)
    trace = read(tmp_path, text, negative=("force",))
    assert trace.force.max() > 99 and "the sign of the force was reversed" in (trace.understood)
    rows_down = [f"{-x},{f}" for _, x, f in zip(*curve(), strict=True)]
    falling = "\n".join(["Extension (mm),Load (N)", *rows_down, ""])
    with pytest.raises(FileError, match="elongation falls by 7.67 mm"):
        read(tmp_path, falling)
    assert read(tmp_path, falling, negative=("elongation",)).elongation[-1] > 0


def test_repeated_stamps_and_a_missing_line_end_are_warnings(tmp_path: Path) -> None:
    body = rows()
    body[5] = "0.0400" + body[5][6:]
    trace = read(tmp_path, "\n".join(["Time (s),Extension (mm),Load (N)", *body]))
    assert len(trace) == 60 and len(trace.warnings) == 2
    assert "1 of 60 time stamps repeat" in " ".join(trace.warnings)


def test_a_file_that_says_it_is_synthetic(tmp_path: Path) -> None:
    text = '"Operator","SYNTHETIC"\n\n' + "\n".join(
        ["Time (s),Extension (mm),Load (N)", *rows(), ""]
    )
    assert any("synthetic" in w for w in read(tmp_path, text).warnings)


def test_a_genuine_plateau_is_no_saturation(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    travel = np.linspace(0, 40, 4000)
    for noise, step in ((0.05, 0.01), (0.05, 0.1), (0.3, 0.1)):
        force = np.minimum(100 * travel, 100) + rng.normal(0, noise, 4000)
        force = np.round(force / step) * step
        body = [f"{x:.4f},{f:.2f}" for x, f in zip(travel, force, strict=True)]
        assert len(read(tmp_path, "\n".join(["Extension (mm),Load (N)", *body, ""]))) == 4000
    smooth = np.round((100 - (travel - 20) ** 2 / 10) / 0.5) * 0.5  # coarse, but a true peak
    body = [f"{x:.4f},{f:.1f}" for x, f in zip(travel, smooth, strict=True)]
    assert len(read(tmp_path, "\n".join(["Extension (mm),Load (N)", *body, ""]))) == 4000
    held = np.minimum(travel, 10)  # the crosshead stops at the greatest force and waits
    body = [f"{x:.4f},{10 * x:.4f}" for x in held]
    assert len(read(tmp_path, "\n".join(["Extension (mm),Load (N)", *body, ""]))) == 4000


def test_wrong_answers_are_refused(tmp_path: Path) -> None:
    for wrong in ({"negative": ("Kraft",)}, {"reading": "abs"}, {"decimal": ";"}):
        with pytest.raises(LayerjamError):
            ReadingOptions(**wrong)
    with pytest.raises(FileError, match="has no column 'Weg' with a unit of elongation"):
        read(tmp_path, encoded("named"), column=["elongation=Weg"])
    with pytest.raises(FileError, match="has no column 'x'"):
        read(tmp_path, encoded("own"), columns="force=x")
    assert len(read(tmp_path, encoded("own"), column=["force=force"])) == 60


@pytest.mark.parametrize("first", ["", '"Shimadzu Autograph"\n'])
def test_a_quoted_row_of_units_alone_is_no_brands(first: str, tmp_path: Path) -> None:
    """Shimadzu writes it too."""
    head = first + '"Time","Stroke","Force"\n"sec","mm","N"\n'
    trace = read(tmp_path, head + "\n".join(rows()) + "\n")
    assert trace.format == ("Shimadzu Trapezium" if first else "table of columns")


def test_small_parts() -> None:
    assert unit_role("kN") == ("force", Fraction(1000))
    assert unit_role("N·m") is None and unit_role("mm/min") is None and unit_role("%") is None
    assert split_unit("Kraft [N]") == ("Kraft", "N") and split_unit("N/A") == ("N/A", None)
    assert find_role("Prüfkraft") == "force" and find_role("Drehmoment Torque") is None


@pytest.mark.parametrize(
    "module", ["measure.options", "measure.sidecar", "measure.readers.read", "campaigns.campaign"]
)
def test_imports_stay_light(module: str) -> None:
    heavy = {"jax", "pandas", "pint"}
    code = f"import sys, layerjam.{module}; print({heavy} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


@pytest.mark.skipif(not REAL.is_dir(), reason="the real exports are not here")
class TestRealFiles:
    @pytest.mark.parametrize(
        ("name", "count", "peak", "column"),
        [
            ("Allong_1.TRA", 2184, 2443.02, "Course standard"),
            ("Invar_LT_05_01.TRA", 5336, 7407.26, "Standard travel"),
            ("mDB1pct.TRA", 3415, 3708.59, "Standard travel"),
        ],
    )
    def test_testxpert(self, name: str, count: int, peak: float, column: str) -> None:
        trace = read_trace(REAL / "testxpert_tra" / name)
        assert trace.format == "Zwick testXpert" and len(trace) == count
        assert trace.force.max() == peak and trace.elongation[0] == 0 and trace.warnings == ()
        assert any(f"'{column}' in mm" in s for s in trace.understood)
        lines = (REAL / "testxpert_tra" / name).read_text("latin-1").splitlines()
        body = [line.split(",") for line in lines[12:]]
        at = lines[10].replace('"', "").split(",").index(column)
        np.testing.assert_array_equal(trace.elongation, [float(r[at]) / 1000 for r in body])

    @pytest.mark.parametrize(
        ("name", "sentence"),
        [
            ("bluehill_like/sample_bluehill.csv", "the force of largest magnitude is negative"),
            ("bluehill_like/sample_wavematrix_torsion.csv", "no column with a unit of elongation"),
            ("silicone_tensile/Ecoflex_00-10.csv", "no column with a unit of elongation"),
            ("silicone_tensile/Dragon_Skin_30.csv", "'Engineering Stress' [MPa]"),
            ("pneumatic_friction_leak/friction_Circle_1bar.csv", "is not in a known format"),
            ("pneumatic_friction_leak/airchamber_Prusa.csv", "is not in a known format"),
        ],
    )
    def test_others_are_refused_in_a_sentence(self, name: str, sentence: str) -> None:
        with pytest.raises(FileError) as err:
            read_trace(REAL / name)
        assert sentence in str(err.value) and "\n" not in str(err.value)

    def test_compression_read_on_request(self) -> None:
        path = REAL / "bluehill_like" / "sample_bluehill.csv"
        trace = read_trace(path, ReadingOptions(negative=("force",)))
        assert trace.force.max() == 1500 and trace.elongation[0] == 0.01


def test_a_sign_turned_in_vain_is_said(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="once its sign is changed"):
        read(tmp_path, encoded("bluehill"), negative=("force",))
