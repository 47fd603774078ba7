"""Interrupts on the command line: Ctrl-C ends a command, also within JAX's garbage collection."""

import signal
import threading
from types import FrameType

from layerjam.core.store import Appearing


def handle_interrupts() -> None:
    """Let Ctrl-C raise KeyboardInterrupt, unless the process already handles it differently."""
    is_main = threading.current_thread() is threading.main_thread()
    if is_main and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _raise_interrupt)


def _raise_interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, but not in JAX's callback of the garbage collector.

    Python would print and ignore an exception there, and the program would continue, so it is
    raised later. While the files of a result appear, the command ends by itself within a moment,
    and the interrupt is ignored.
    """
    if Appearing.begun:
        return
    Appearing.interrupted = True
    place = frame
    while place is not None:
        if place.f_code.co_name == "_xla_gc_callback":
            timer = threading.Timer(0.02, signal.raise_signal, (number,))
            timer.daemon = True
            timer.start()
            return
        place = place.f_back
    signal.default_int_handler(number, frame)
