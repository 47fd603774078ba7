"""The closed loops in C, printed from the Python sources, so that each rule is written once.

`python tests/print_c.py` rewrites `brake/kernel/c/loops/loops.c`; a test checks it.
"""

from c_printers.printer import format_program
from layerjam.bench.control import closed_loop_run, exact, law, noise, sample, through_tube, trial

RECORDS = (exact.Rates, noise.Layers, closed_loop_run.Chain, closed_loop_run.Course)
FUNCTIONS = (
    law.fresh,
    law.move_drive,
    law.switch_pump,
    law.make_safe_drive,
    law.compute_drive,
    law.healthy_rise,
    law.healthy_rises,
    law.update_surplus,
    law.check_pump,
    law.watch_vent,
    law.watch_target,
    law.detect,
    law.step,
    noise.mix_bits,
    noise.uniform,
    noise._draw_from_tail,
    noise.normal,
    exact.step_factors,
    through_tube._slopes,
    through_tube.advance,
    sample.advance_plant,
    closed_loop_run.read_sensor,
    closed_loop_run.find_crossing,
    closed_loop_run.run_loop,
    trial.run_trial,
)
"""Functions in the order of printing; each uses only earlier ones."""


EXPORTED = {"run_loop", "run_trial"}
SEPARATE_FUNCTIONS = {"_draw_from_tail", "advance"}
"""Functions that are rarely called: inlined, they would slow down the rest."""


def format_loops() -> str:
    """Return the text of `loops.c`."""
    return format_program(
        "tests/c_printers/c_program.py", FUNCTIONS, RECORDS, EXPORTED, SEPARATE_FUNCTIONS
    )
