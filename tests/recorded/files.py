"""Files that the recorded results are computed from: brakes, a virtual campaign, and logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import layerjam as lj
from layerjam.brake.device.load import load

EFFECTS = {
    "aged": {"ageing": 0.02, "static_hold": 10.0},
    "exponent": {"pressure_exponent": -0.1, "test_pressure": 3.9e3},
    "fan": {"spacers": False},
    "speed-law": {
        "speed_law_power": 0.05,
        "speed_law_test_speed": 7e-3,
        "speed_law_rest_speed": 1e-4,
    },
    "rubber": {
        "hyperelastic_strain": 12.0,
        "hyperelastic_c10": 11e3,
        "hyperelastic_c20": 300.0,
        "hyperelastic_softening_r": 1.7,
        "hyperelastic_softening_m": 4e3,
        "hyperelastic_softening_beta": 0.2,
    },
}
CAMPAIGN = """
seed = 5
[[brakes]]
brake = "choi2018-kapton"
label = "k"
scale_factor = 0.92
stiffness = "120 kN/m"
enclosure_factor = 1.1
static = 0.31
kinetic = 0.235
ageing = 0.02
[pulls]
vacuums = ["40 kPa", "80 kPa"]
speeds = ["7 mm/s"]
repeats = 3
travel = "25 mm"
unload = "3 mm"
[friction]
repeats = 2
holds = ["10 s", "100 s", "1000 s"]
sampling_rate = "50 Hz"
travel = "60 mm"
force_offset = "20 mN"
stick_slip = "10 mN"
[machine]
sampling_rate = "100 Hz"
force_offset = "0.4 N"
force_drift = "5 mN/s"
compliance = "0.2 um/N"
jitter = "0.5 ms"
repeated_stamps = 0.003
overshoot = 0.05
seating = "0.2 mm"
warming = "2 K"
zero_per_kelvin = "20 mN"
[files]
layouts = ["bluehill", "testxpert", "mts"]
[practice]
cut_off = 0
"""
DESIGN = """
name = "grip"
brake = "choi2018-kapton"
line = "choi2018"
constraints = ["holding_force >= 250 N", "mass <= 30 g", "stress_margin >= 2"]
objectives = ["minimise mass", "maximise energy_capacity"]
weights = [2, 1]
[[film]]
use = "choi2018-kapton"
thickness = ["25.4 um", "50.8 um", "76.2 um"]
[vary]
count = { from = 9, to = 31, step = 2 }
width = ["12 mm", "16 mm", "20 mm", "24 mm"]
overlap = ["40 mm", "60 mm", "80 mm"]
vacuum = ["60 kPa", "94.5 kPa"]
"""
WORKSHOP = """
[build]
edge = "1.7 mm"
floor = "1.5 mm"
wall = "1.4 mm"
cheek = "1.9 mm"
side = "0.4 mm"
fit = "0.25 mm"
head_room = "0.3 mm"
plenum = "1.3 mm"
back = "3.3 mm"
air_bore = "2.2 mm"
neck_length = "9 mm"
neck_stretch = 0.3
tie_slot = "3.7 mm"
tie_depth = "0.7 mm"
pin = "5 mm"
pin_clearance = "0.15 mm"
pin_wall = "3.4 mm"
sleeve_clearance = "0.2 mm"
shrinkage = 0.004
trim = "6 mm"
mould_wall = "5.5 mm"
core_print = "11 mm"
core_clearance = "0.12 mm"
sprue = "4.4 mm"
vent = "1.7 mm"
key = "4.3 mm"
key_clearance = "0.35 mm"
waste = 0.4
tip_radius = "1.6 mm"
clamp_radius = "0.7 mm"
margin = "7 mm"
gap = "4 mm"
nut_factor = 0.23
print_density = "1210 kg/m^3"
"""
"""Another workshop, none of whose numbers is 1 in the unit of a drawing or the default."""


def write_brakes(folder: Path) -> None:
    """Write the Kapton brake with one effect each."""
    for name, fields in EFFECTS.items():
        brake = load("choi2018-kapton").with_(**fields)
        (folder / f"{name}.toml").write_text(brake.text, encoding="utf-8")


def write_columns(path: Path, header: str, *columns: object) -> None:
    table = np.column_stack([np.asarray(column, float) for column in columns])
    rows = [",".join(f"{value:.6g}" for value in row) for row in table]
    path.write_text("\n".join([header, *rows, ""]), encoding="utf-8")


def write_vacuums(folder: Path) -> None:
    """Write vacuums that change while a mass is stopped, and the paper's line with a tube."""
    write_columns(folder / "falling.csv", "time [ms],vacuum [kPa]", [0, 4, 9, 30], [70, 70, 35, 20])
    write_columns(folder / "rising.csv", "time [ms],vacuum [kPa]", [-5, 0, 12, 60], [5, 20, 80, 85])
    tube = lj.load_line("choi2018").with_(tube_length=2.0, tube_bore=2e-3)
    (folder / "tube.toml").write_text(tube.text, encoding="utf-8")


def write_logs(folder: Path) -> None:
    """Write logs of a leak, two evacuations, a crash and a pull of silicone, without noise."""
    ripple = 3e-4 * np.sin(np.arange(400) ** 2)
    time = np.linspace(0, 60, 400)
    leak = 101.325 - 80 * np.exp(-time / 200) + 30 * ripple
    write_columns(folder / "leak.csv", "time (s),pressure (kPa abs)", time, leak)
    for name, volume in (("alone", 1.0), ("larger", 1.6)):
        clock = np.linspace(0, 20, 400)
        pressure = 8 + 93.325 * np.exp(-clock / (3 * volume)) + 30 * ripple
        write_columns(folder / f"{name}.csv", "time (s),pressure (kPa abs)", clock, pressure)
    clock = np.arange(400) / 2000
    pulse = np.where((clock > 0.05) & (clock < 0.12), 30 * np.sin((clock - 0.05) / 0.07 * np.pi), 0)
    write_columns(folder / "crash.csv", "time (s),acceleration (g)", clock, pulse + 20 * ripple)
    strain = np.linspace(0, 4, 400)
    stretch = 1 + strain
    stress = 2 * (stretch - stretch**-2) * (0.012 + 2e-4 * (stretch**2 + 2 / stretch - 3))
    write_columns(
        folder / "silicone.csv",
        "extension (mm),load (N)",
        33 * strain,
        20 * stress + 0.02 * ripple,
    )


def write_files(folder: Path) -> None:
    """Write everything into a new folder."""
    folder.mkdir()
    write_brakes(folder)
    write_vacuums(folder)
    write_logs(folder)
    (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    (folder / "grip.toml").write_text(DESIGN, encoding="utf-8")
    (folder / "workshop.toml").write_text(WORKSHOP, encoding="utf-8")
    lj.lab(folder / "campaign.toml", out=folder / "lab")
