"""The board's loop: a sample every 10 ms at absolute deadlines, and the serial line in between."""

import gc
import sys

import begin
import ticks
from port import Port

from bench import Bench

COLLECT = 50
"""Number of samples between two garbage collections."""
ANSWERED, PATIENT = 5, 100
"""Minimum and maximum number of samples between a reset request and the reset: the board first
sends its response, but gives up if nobody reads it."""


class Reset(Exception):
    """Raised to restart the board."""


def run_loop(hal) -> None:
    """Serve until the line closes (EOFError) or a reset is requested (Reset)."""
    bench = Bench(hal)
    port = Port(bench)
    if hal.collects:
        # collect the garbage from start-up now, not in the middle of a sample
        gc.collect()
    due = hal.ticks_us()
    while True:
        late = ticks.diff(hal.ticks_us(), due)
        if late >= 0:
            bench.tick(late)
            hal.show_state(bench.state, bench.sync)
            if hal.collects and bench.count % COLLECT == 0:
                start = hal.ticks_us()
                gc.collect()
                hal.collected = max(hal.collected, ticks.diff(hal.ticks_us(), start))
            due = ticks.add(due, ticks.PERIOD)
            if late > 10 * ticks.PERIOD:
                due = ticks.add(hal.ticks_us(), ticks.PERIOD)
        data = hal.wait(due, not port.is_full(), bool(port.outbox))
        if data:
            port.process_bytes(data)
        port.resume()
        if port.outbox:
            port.drop_sent(hal.send(port.unsent_bytes()))
        if bench.leaving >= 0:
            waited_samples = bench.count - bench.leaving
            if waited_samples > PATIENT or (waited_samples > ANSWERED and not port.outbox):
                hal.reset()


def make_hal(words: list):
    """Return the HAL of the machine on which this runs."""
    if sys.platform == "rp2":
        import hal_rp2

        return hal_rp2.Hal(words, Reset)
    if sys.implementation.name == "micropython":
        import hal_pipe

        return hal_pipe.Hal(words, Reset)
    import hal_cpython

    return hal_cpython.make_hal(words, Reset)


def main(words: list) -> None:
    """Run until the line closes; after each reset, start with new objects."""
    hal = make_hal(words)
    while True:
        try:
            run_loop(hal)
        except Reset:
            hal.cause = "SOFT"
        except EOFError:
            return
        except Exception as error:
            hal.handle_crash(error)


if __name__ == "__main__" and not begin.maintenance:
    main(sys.argv[1:])
