"""Code of a user with mypy and pyright, both strict; it is checked, never run."""

from __future__ import annotations

from pathlib import Path
from typing import Any, assert_type

import numpy as np
import numpy.typing as npt

import layerjam as lj

KAPTON = "choi2018-kapton"


def stops() -> list[float]:
    """What can be infeasible is required, then its numbers are floats."""
    stop = lj.drop(KAPTON, mass="1 kg", speed=2.5, vacuum="tuned", travel=0.04)
    assert_type(stop.slip, float | None)
    assert_type(stop.feasible, bool)
    sure = stop.require()
    assert_type(sure.slip, float)
    assert_type(sure.outcome, str)
    sure.plot("stop.svg")
    tuned = lj.tune(KAPTON, mass=1, speed=2.5, travel="40 mm").require()
    line = lj.rise("choi2018", target="80 kPa").require()
    return [sure.slip * 2, sure.peak_force / 9.81, tuned.vacuum + 1, line.rise_time * 2]


def single_numbers() -> float:
    """A result of single numbers has floats."""
    force = lj.force(KAPTON, slip="20 mm", vacuum=94.5e3)
    assert_type(force.force, float)
    needed = lj.vacuum(KAPTON, slip=0.02, force="100 N")
    assert_type(needed.vacuum, float | None)
    assert_type(needed.require().vacuum, float)
    assert_type(lj.show(KAPTON).mass, float)
    assert_type(lj.show(KAPTON).require().stiffness_measured, float)
    fit = lj.calibrate(KAPTON, Path("pull.csv"), vacuum="94.5 kPa")
    return force.force + needed.require().vacuum + fit.scale_factor


def arrays(slip: npt.NDArray[np.float64]) -> Any:
    """A result of arrays has arrays, NumPy's or xarray's."""
    grid = lj.force(KAPTON, slip=slip[:, None], vacuum=["20 kPa", "90 kPa"])
    each = lj.vacuum(KAPTON, slip=slip, force=100)
    frame = grid.to_frame()
    return grid.force.max(), each.vacuum[each.feasible], frame


def brakes() -> float:
    """Constructors take text, attributes are numbers."""
    sheets = lj.Sheets(
        count=11,
        width="13 mm",
        thickness=0.254e-3,
        length="120 mm",
        overlap=np.float64(0.068),
        free_left="1 cm",
        free_right="1 cm",
        usable_travel="60 mm",
    )
    brake = lj.load(KAPTON).with_(width="14 mm").brake
    rope = lj.Rope(stiffness="16.8 kN/m", damping=5)
    assert_type(sheets.width, float)
    assert_type(brake.film.ageing, float | None)
    return sheets.width + rope.stiffness + lj.Site(atmosphere="90 kPa").atmosphere


def errors() -> str:
    """An error has a key for programs."""
    try:
        return lj.lab("practice", out="practice").folder or ""
    except lj.LayerjamError as error:
        return error.key


EVERY: tuple[Any, ...] = (
    lj.Accelerometer, lj.Brake, lj.BrakeFile, lj.Campaign, lj.DropRecord, lj.Enclosure, lj.Film,
    lj.History, lj.Housing, lj.Interfaces, lj.LayerjamError, lj.Mount, lj.Notice, lj.Outcome,
    lj.Procedure, lj.ReadingOptions, lj.Result, lj.Rope, lj.Sensing, lj.Sheets, lj.Site, lj.Source,
    lj.Standard, lj.Stribeck, lj.TensileRecord, lj.Trace, lj.Warmth, lj.ageing, lj.array, lj.batch,
    lj.bench_check, lj.bench_clear, lj.bench_export, lj.bench_faults, lj.bench_flash, lj.bench_log,
    lj.bench_run, lj.bench_serve, lj.bench_soak, lj.bench_status, lj.bench_wiring, lj.bench_zero,
    lj.bend, lj.build, lj.calibrate, lj.catalogue, lj.compare, lj.crash, lj.demo, lj.design,
    lj.design_brake, lj.design_new, lj.drop, lj.edit, lj.edit_line, lj.enclosure,
    lj.example_campaign, lj.export_c, lj.export_fmu, lj.export_html, lj.export_mujoco, lj.follow,
    lj.force, lj.friction, lj.heating, lj.lab, lj.laws, lj.leak, lj.load, lj.load_line,
    lj.load_spec, lj.new, lj.observed, lj.parse_procedure, lj.parts, lj.plan, lj.publish, lj.pull,
    lj.pump_down, lj.read_history, lj.read_log, lj.read_trace, lj.read_traces, lj.reading,
    lj.recompute, lj.records_add, lj.records_list, lj.records_show, lj.records_verify,
    lj.records_withdraw, lj.regulate, lj.report, lj.reproduce, lj.rise, lj.scenario, lj.schema,
    lj.show, lj.stick_slip, lj.sweep, lj.tensile, lj.tune, lj.vacuum, lj.validate,
    lj.write_campaign, lj.write_report,
)  # fmt: skip
"""Every public name: those that `dir(layerjam)` lists."""
