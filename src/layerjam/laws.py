"""The laws: pure array functions of SI quantities and a brake, one for each equation.

They can be broadcast, traced, differentiated and batched by JAX, and accept a Brake or a BrakeFile.
When called with numbers, they compute in double precision, whatever the process has set. When
traced, they need ``jax.config.update("jax_enable_x64", True)``.
"""

from layerjam.brake.device.brake import enclosure_mass as enclosure_mass
from layerjam.brake.device.brake import mass as mass
from layerjam.brake.device.brake import sheet_mass as sheet_mass
from layerjam.brake.mechanics.ageing import aged_holding_force as aged_holding_force
from layerjam.brake.mechanics.ageing import aged_static as aged_static
from layerjam.brake.mechanics.bending import bending_stiffness_free as bending_stiffness_free
from layerjam.brake.mechanics.bending import bending_stiffness_jammed as bending_stiffness_jammed
from layerjam.brake.mechanics.bending import buckling_moment as buckling_moment
from layerjam.brake.mechanics.bending import cantilever_deflection as cantilever_deflection
from layerjam.brake.mechanics.bending import cantilever_force as cantilever_force
from layerjam.brake.mechanics.bending import (
    enclosure_bending_stiffness as enclosure_bending_stiffness,
)
from layerjam.brake.mechanics.bending import shear_at_first_slip as shear_at_first_slip
from layerjam.brake.mechanics.bending import shear_at_full_slip as shear_at_full_slip
from layerjam.brake.mechanics.bending import slip_moment as slip_moment
from layerjam.brake.mechanics.bending import turning_moment as turning_moment
from layerjam.brake.mechanics.bending import turning_stiffness_free as turning_stiffness_free
from layerjam.brake.mechanics.bending import turning_stiffness_jammed as turning_stiffness_jammed
from layerjam.brake.mechanics.enclosure import enclosure_force as enclosure_force
from layerjam.brake.mechanics.enclosure import enclosure_stretch as enclosure_stretch
from layerjam.brake.mechanics.enclosure import saturation_slip as saturation_slip
from layerjam.brake.mechanics.energy import energy_capacity as energy_capacity
from layerjam.brake.mechanics.energy import pull_work as pull_work
from layerjam.brake.mechanics.energy import slip_heat as slip_heat
from layerjam.brake.mechanics.energy import slip_work as slip_work
from layerjam.brake.mechanics.fan import amplification as amplification
from layerjam.brake.mechanics.friction import holding_force as holding_force
from layerjam.brake.mechanics.friction import sheet_friction as sheet_friction
from layerjam.brake.mechanics.heat import local_rise as local_rise
from layerjam.brake.mechanics.heat import stops_per_minute as stops_per_minute
from layerjam.brake.mechanics.heat import temperature_rise as temperature_rise
from layerjam.brake.mechanics.heat import temperature_rise_of_sheets as temperature_rise_of_sheets
from layerjam.brake.mechanics.hysteresis import brake_cycle as brake_cycle
from layerjam.brake.mechanics.joint import capstan_ratio as capstan_ratio
from layerjam.brake.mechanics.joint import joint_friction as joint_friction
from layerjam.brake.mechanics.joint import joint_sheet_force as joint_sheet_force
from layerjam.brake.mechanics.limits import buckling_force as buckling_force
from layerjam.brake.mechanics.limits import clamp_stress as clamp_stress
from layerjam.brake.mechanics.limits import self_closing_vacuum as self_closing_vacuum
from layerjam.brake.mechanics.limits import sheet_stress as sheet_stress
from layerjam.brake.mechanics.limits import travel_left as travel_left
from layerjam.brake.mechanics.memory import enclosure_cycle as enclosure_cycle
from layerjam.brake.mechanics.pull import brake_force as brake_force
from layerjam.brake.mechanics.pull import force_at_elongation as force_at_elongation
from layerjam.brake.mechanics.pull import force_limits as force_limits
from layerjam.brake.mechanics.pull import least_stiffness as least_stiffness
from layerjam.brake.mechanics.pull import peak as peak
from layerjam.brake.mechanics.pull import peak_vacuum as peak_vacuum
from layerjam.brake.mechanics.pull import scale_factor_of_peak as scale_factor_of_peak
from layerjam.brake.mechanics.pull import slip_at_elongation as slip_at_elongation
from layerjam.brake.mechanics.pull import vacuum_for_force as vacuum_for_force
from layerjam.brake.mechanics.stick_slip.laws import critical_speed as critical_speed
from layerjam.brake.mechanics.stick_slip.laws import sliding_force as sliding_force
from layerjam.brake.mechanics.stick_slip.laws import slow_saw as slow_saw
from layerjam.brake.mechanics.stick_slip.laws import stable_speed as stable_speed
from layerjam.brake.mechanics.stick_slip.laws import (
    stiffness_without_stick_slip as stiffness_without_stick_slip,
)
from layerjam.brake.mechanics.stick_slip.laws import stribeck_friction as stribeck_friction
from layerjam.brake.mechanics.stick_slip.laws import undamped_saw as undamped_saw
from layerjam.brake.mechanics.stick_slip.stribeck import Stribeck as Stribeck
from layerjam.brake.mechanics.stick_slip.wet import WetFilm as WetFilm
from layerjam.brake.mechanics.stick_slip.wet import wet_force as wet_force
from layerjam.brake.mechanics.stick_slip.wet import wet_stress as wet_stress
from layerjam.brake.mechanics.stiffness import mount_stiffness as mount_stiffness
from layerjam.brake.mechanics.stiffness import stiffness_before_slip as stiffness_before_slip
from layerjam.brake.mechanics.stiffness import stiffness_sliding as stiffness_sliding
from layerjam.brake.mechanics.stop.exact import speed_at_slip as speed_at_slip
from layerjam.brake.mechanics.stop.exact import stop as stop
from layerjam.brake.mechanics.stop.exact import time_at_slip as time_at_slip
from layerjam.brake.mechanics.stop.motion import stop_in_time as stop_in_time
from layerjam.brake.mechanics.stop.tune import tuned_vacuum as tuned_vacuum
from layerjam.brake.mechanics.stop.tune import vacuum_eq10 as vacuum_eq10
