"""Questions with the options that the other recorded questions leave at their defaults."""

from __future__ import annotations

from recorded.questions import (
    HELD,
    OWN,
    PULL,
    PULLS,
    SAFE,
    STOP,
    WINDOW,
    F,
    K,
    P,
    Question,
    Y,
    ask,
)

THIN = {"atmosphere": "85 kPa"}


def brake_options() -> dict[str, Question]:
    """Thin air, another film, means of many tests, sensors and temperatures."""
    made: dict[str, Question] = {
        "force film": ask("force", K, slip="9 mm", vacuum="40 kPa", film=P),
        "vacuum sure": ask("vacuum", P, slip="9 mm", force="30 N", confidence=0.8, **THIN),
        "vacuum mean": ask("vacuum", K, slip="9 mm", force="30 N", interval="mean"),
        "show thin": ask("show", F, interval="mean", **THIN),
        "tune thin": ask("tune", Y, speed="1.2 m/s", **STOP, **THIN),
        "tune too fast": ask("tune", K, speed="6 m/s", rope_stiffness="12 kN/m", **STOP),
        "tune mean": ask("tune", K, speed="1.2 m/s", interval="mean", **STOP),
        "bend thin": ask("bend", F, vacuum="60 kPa", angle="25 deg", radius="90 mm", **THIN),
        "array thin": ask("array", Y, parallel=2, series=3, vacuum="60 kPa", until="90 mm",
                          interval="mean", **THIN),
        "compare thin": ask("compare", K, P, Y, vacuum="60 kPa", interval="mean", **THIN),
        "saw mounted": ask("stick-slip", K, vacuum="60 kPa", mass="0.7 kg", speed="2 mm/s",
                           mount_stiffness="90 kN/m", elongation="6 mm", **THIN),
        "tensile leaking": ask("tensile", P, elongation="9 mm", leak_time="30 s", **PULL),
        "tensile mean": ask("tensile", K, elongation="9 mm", interval="mean", **PULL, **THIN),
        "drop flat": ask("drop", K, speed="1.5 m/s", vacuum="80 kPa", mass="1.3 kg",
                         horizontal=True, rope_stiffness="8 kN/m", interval="mean"),
        "drop felt through": ask("drop", P, speed="1.8 m/s", vacuum="80 kPa", mass="1.3 kg",
                                 accelerometer="adxl193", low_pass="150 Hz",
                                 sampling="4 kHz", rope_stiffness="9 kN/m"),
        "drop filtered": ask("drop", K, speed="1.8 m/s", vacuum="80 kPa", mass="1.3 kg",
                             accelerometer="adxl193", filter_class="CFC180"),
        "drop warm": ask("drop", P, speed="1.2 m/s", vacuum="80 kPa", mass="1.3 kg",
                         allowed_rise="5 K", film_coefficient="25 W/(m^2 K)"),
        "drop crashes": ask("drop", K, speed="4 m/s", vacuum="80 kPa", mass="2.1 kg",
                            rope_stiffness="9 kN/m"),
        "drop snaps": ask("drop", K, speed="2 m/s", vacuum="90 kPa", mass="3 kg",
                          rope_stiffness="1.2 kN/m"),
        "drop shared": ask("drop", F, speed="1.2 m/s", vacuum="80 kPa", mass="1.3 kg",
                           vacuum_share=0.85, travel=None, **THIN),
        "drop bare damped": ask("drop", K, speed="1.5 m/s", no_brake=True, mass="1.3 kg",
                                rope_stiffness="5 kN/m", rope_damping="40 N s/m"),
    }  # fmt: skip
    for own in OWN[:3]:
        name = own.removesuffix(".toml")
        made[f"array {name}"] = ask("array", own, parallel=2, series=2, vacuum="60 kPa",
                                   until="40 mm")  # fmt: skip
        made[f"bend {name}"] = ask("bend", own, vacuum="60 kPa", angle="40 deg",
                                  radius="40 mm")  # fmt: skip
    return made


def bench_options() -> dict[str, Question]:
    """Other control laws, fluids, noise, standing vacuums, tubes and leaks."""
    line = "choi2018"
    return {
        "regulate scheduled": ask("regulate", line, target="35 kPa", kind="scheduled",
                                  duration="6 s", reversible=True, noise="30 Pa", **SAFE),
        "regulate resting": ask("regulate", line, target="55 kPa", kind="bang-bang",
                                duration="9 s", least_run="0.6 s", **SAFE, **THIN),
        "regulate logged": ask("regulate", line, target="55 kPa", step="alone.csv", start="1 s",
                               end="15 s", duration="9 s", **SAFE),
        "follow noisy": ask("follow", line, K, profile="step", low="20 N", high="70 N",
                            period="8 s", duration="8 s", speed="1 mm/s", noise="40 Pa",
                            slip_noise="0.1 mm", model_error=1.1, kind="pi", seed=3, **SAFE),
        "follow water": ask("follow", line, P, profile="sine", low="10 N", high="40 N",
                            period="9 s", duration="9 s", speed="1 mm/s", fluid="water",
                            sample_time="20 ms", least_run="0.1 s", **THIN, **SAFE),
        "rise thin": ask("rise", line, target="60 kPa", **THIN),
        "plan standing": ask("plan", line, K, mass="1 kg", speed="1 m/s", warning="0.5 s",
                             travel="50 mm", standing="20 kPa",
                             rope_stiffness="20 kN/m", mass_sd="0.1 kg", samples=2000, seed=7,
                             vacuum_share=0.9),
        "leak part": ask("leak", "leak.csv", volume="0.2 l", zero="-1 kPa", start="5 s",
                         end="45 s", atmosphere="100 kPa"),
        "pump-down part": ask("pump-down", "alone.csv", volume="0.17 l", start="1 s",
                              end="14 s", zero="0.5 kPa"),
        "pump-down flow": ask("pump-down", "alone.csv", flow="50 ml/s", compliance="0.01 ml/kPa"),
        "crash falling": ask("crash", "crash.csv", filter_class="CFC180", hic="36 ms",
                             falling=True, before="30 ms", sensor_range="250 g"),
    }  # fmt: skip


def laboratory_options() -> dict[str, Question]:
    """Standards, partial fits and exclusions."""
    held, pulls = list(HELD[:2]), list(PULLS)
    return {
        "friction d1894": ask("friction", held, standard="d1894", **WINDOW),
        "friction iso8295": ask("friction", held, standard="iso8295", area="625 mm^2"),
        "friction loaded": ask("friction", held, normal_force="2.6 N", **WINDOW),
        "friction jerking": ask("friction", held, accept_stick_slip=True, **WINDOW),
        "ageing loaded": ask("ageing", list(HELD), normal_force="2.6 N", **WINDOW),
        "calibrate thin": ask("calibrate", K, pulls[:4], **THIN),
        "validate others": ask("validate", P, pulls[3:], exclude=[pulls[4]], because="t", **THIN),
        "enclosure part": ask("enclosure", ["silicone.csv"], area="20 mm^2",
                              gauge_length="33 mm", fit_to=2.0, start=0.05, end=0.3,
                              material="ecoflex-00-30"),
        "report": ask("report", K, out="report", pulls=pulls[:3], friction=held, **WINDOW),
    }  # fmt: skip


def workshop_options() -> dict[str, Question]:
    """Coupons, chains, other programs' models and another design."""
    return {
        "build chain": ask("build", F, out="chain", series=2, coupons=True, no_step=True,
                           cutter="knife"),
        "build own": ask("build", Y, out="own", parallel=3, no_step=True, cutter="service",
                         print_bed="220x220x250 mm"),
        "design second": ask("design", "grip.toml", number=2, out="second.toml", confidence=0.9,
                             interval="mean"),
        "export-c single": ask("export-c", P, out="single", precision="single",
                               rope_stiffness="9 kN/m"),
        "export-html": ask("export-html", K, out="page.html", rope_stiffness="9 kN/m"),
        "export-fmu": ask("export-fmu", K, out="brake.fmu", sources_only=True,
                          rope_stiffness="9 kN/m"),
        "export-mujoco": ask("export-mujoco", K, out="model.xml", no_build=True,
                             vacuum_lag="0.2 s", rope_stiffness="9 kN/m"),
    }  # fmt: skip


OPTIONS = brake_options() | bench_options() | laboratory_options() | workshop_options()
