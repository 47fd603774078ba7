"""The laws: pure array functions of SI quantities and a brake, one equation each.

They broadcast, trace, differentiate and batch with JAX, and take a Brake or a BrakeFile. Called on
numbers they compute in double precision whatever the process has set; traced, they need
``jax.config.update("jax_enable_x64", True)``.
"""

from layerjam.device.brake import enclosure_mass, mass, sheet_mass
from layerjam.mechanics.ageing import aged_holding_force, aged_static
from layerjam.mechanics.bending import (
    bending_stiffness_free,
    bending_stiffness_jammed,
    buckling_moment,
    cantilever_deflection,
    cantilever_force,
    enclosure_bending_stiffness,
    shear_at_first_slip,
    shear_at_full_slip,
    slip_moment,
    turning_moment,
    turning_stiffness_free,
    turning_stiffness_jammed,
)
from layerjam.mechanics.enclosure import enclosure_force, enclosure_stretch, saturation_slip
from layerjam.mechanics.energy import energy_capacity, pull_work, slip_heat, slip_work
from layerjam.mechanics.fan import amplification
from layerjam.mechanics.friction import holding_force, sheet_friction
from layerjam.mechanics.heat import (
    local_rise,
    stops_per_minute,
    temperature_rise,
    temperature_rise_of_sheets,
)
from layerjam.mechanics.hysteresis import brake_cycle
from layerjam.mechanics.joint import capstan_ratio, joint_friction, joint_sheet_force
from layerjam.mechanics.limits import (
    buckling_force,
    clamp_stress,
    self_closing_vacuum,
    sheet_stress,
    travel_left,
)
from layerjam.mechanics.memory import enclosure_cycle
from layerjam.mechanics.pull import (
    brake_force,
    force_at_elongation,
    force_limits,
    least_stiffness,
    peak,
    peak_vacuum,
    scale_factor_of_peak,
    slip_at_elongation,
    vacuum_for_force,
)
from layerjam.mechanics.stick_slip.curve import Stribeck
from layerjam.mechanics.stick_slip.laws import (
    critical_speed,
    sliding_force,
    slow_saw,
    stable_speed,
    stiffness_without_stick_slip,
    stribeck_friction,
    undamped_saw,
)
from layerjam.mechanics.stick_slip.wet import WetFilm, wet_force, wet_stress
from layerjam.mechanics.stiffness import mount_stiffness, stiffness_before_slip, stiffness_sliding
from layerjam.mechanics.stop.exact import speed_at_slip, stop, time_at_slip
from layerjam.mechanics.stop.motion import stop_in_time
from layerjam.mechanics.stop.tune import tuned_vacuum, vacuum_eq10

__all__ = [
    "Stribeck",
    "WetFilm",
    "aged_holding_force",
    "aged_static",
    "amplification",
    "bending_stiffness_free",
    "bending_stiffness_jammed",
    "brake_cycle",
    "brake_force",
    "buckling_force",
    "buckling_moment",
    "cantilever_deflection",
    "cantilever_force",
    "capstan_ratio",
    "clamp_stress",
    "critical_speed",
    "enclosure_bending_stiffness",
    "enclosure_cycle",
    "enclosure_force",
    "enclosure_mass",
    "enclosure_stretch",
    "energy_capacity",
    "force_at_elongation",
    "force_limits",
    "holding_force",
    "joint_friction",
    "joint_sheet_force",
    "least_stiffness",
    "local_rise",
    "mass",
    "mount_stiffness",
    "peak",
    "peak_vacuum",
    "pull_work",
    "saturation_slip",
    "scale_factor_of_peak",
    "self_closing_vacuum",
    "shear_at_first_slip",
    "shear_at_full_slip",
    "sheet_friction",
    "sheet_mass",
    "sheet_stress",
    "sliding_force",
    "slip_at_elongation",
    "slip_heat",
    "slip_moment",
    "slip_work",
    "slow_saw",
    "speed_at_slip",
    "stable_speed",
    "stiffness_before_slip",
    "stiffness_sliding",
    "stiffness_without_stick_slip",
    "stop",
    "stop_in_time",
    "stops_per_minute",
    "stribeck_friction",
    "temperature_rise",
    "temperature_rise_of_sheets",
    "time_at_slip",
    "travel_left",
    "tuned_vacuum",
    "turning_moment",
    "turning_stiffness_free",
    "turning_stiffness_jammed",
    "undamped_saw",
    "vacuum_eq10",
    "vacuum_for_force",
    "wet_force",
    "wet_stress",
]
