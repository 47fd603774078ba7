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
    lj.Procedure, lj.ReadingOptions, lj.Result, lj.Rope, lj.Sensing, lj.Sheets, lj.Site,
    lj.Source, lj.Standard, lj.Stribeck, lj.TensileRecord, lj.Trace, lj.Warmth, lj.WetFilm,
    lj.aged_holding_force, lj.aged_static, lj.ageing, lj.amplification, lj.array,
    lj.batch, lj.bench_check, lj.bench_clear, lj.bench_export, lj.bench_faults, lj.bench_flash,
    lj.bench_log, lj.bench_run, lj.bench_serve, lj.bench_soak, lj.bench_status, lj.bench_wiring,
    lj.bench_zero, lj.bend, lj.bending_stiffness_free, lj.bending_stiffness_jammed,
    lj.brake_cycle, lj.brake_force, lj.buckling_force, lj.buckling_moment, lj.build,
    lj.calibrate, lj.cantilever_deflection, lj.cantilever_force, lj.capstan_ratio, lj.catalogue,
    lj.clamp_stress, lj.compare, lj.crash, lj.critical_speed, lj.demo, lj.design,
    lj.design_brake, lj.design_new, lj.drop, lj.edit, lj.edit_line, lj.enclosure,
    lj.enclosure_bending_stiffness, lj.enclosure_cycle, lj.enclosure_force,
    lj.enclosure_mass, lj.enclosure_stretch,
    lj.energy_capacity, lj.example_campaign, lj.export_c, lj.export_fmu, lj.export_html,
    lj.export_mujoco,
    lj.follow, lj.force, lj.force_at_elongation, lj.force_limits, lj.friction, lj.heating,
    lj.holding_force, lj.joint_friction, lj.joint_sheet_force, lj.lab, lj.laws, lj.leak,
    lj.least_stiffness, lj.load, lj.load_line, lj.load_spec, lj.local_rise, lj.mass,
    lj.mount_stiffness, lj.new, lj.observed, lj.parse_procedure, lj.parts, lj.peak,
    lj.peak_vacuum, lj.plan, lj.publish, lj.pull, lj.pull_work, lj.pump_down, lj.read_history,
    lj.read_log, lj.read_trace, lj.read_traces, lj.reading, lj.recompute, lj.records_add,
    lj.records_list, lj.records_show, lj.records_verify, lj.records_withdraw, lj.regulate,
    lj.report, lj.reproduce, lj.rise, lj.saturation_slip, lj.scale_factor_of_peak, lj.scenario,
    lj.schema, lj.self_closing_vacuum,
    lj.shear_at_first_slip, lj.shear_at_full_slip, lj.sheet_friction,
    lj.sheet_mass, lj.sheet_stress, lj.show, lj.sliding_force, lj.slip_at_elongation,
    lj.slip_heat, lj.slip_moment, lj.slip_work, lj.slow_saw, lj.speed_at_slip, lj.stable_speed,
    lj.stick_slip, lj.stiffness_before_slip, lj.stiffness_sliding,
    lj.stiffness_without_stick_slip, lj.stop, lj.stop_in_time, lj.stops_per_minute,
    lj.stribeck_friction, lj.sweep, lj.temperature_rise, lj.temperature_rise_of_sheets,
    lj.tensile, lj.time_at_slip, lj.travel_left, lj.tune, lj.tuned_vacuum, lj.turning_moment,
    lj.turning_stiffness_free, lj.turning_stiffness_jammed, lj.undamped_saw, lj.vacuum,
    lj.vacuum_eq10, lj.vacuum_for_force, lj.validate, lj.wet_force, lj.wet_stress,
    lj.write_campaign, lj.write_report,
)  # fmt: skip
"""Every public name: those that `dir(layerjam)` lists."""
