"""JAX for the command line: double precision and working interrupts."""

import contextlib
import os
import signal
import threading
from collections.abc import Iterator
from types import FrameType

from layerjam.mechanics.compilation import keep_compiled_code


def enable_double_precision() -> None:
    """Switch JAX to double precision.

    Only commands that compute call it: importing JAX takes half a second.
    """
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    with _delay_interrupts():
        import jax
    keep_compiled_code()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler and _is_main_thread():
        signal.signal(signal.SIGINT, _raise_interrupt)
    jax.config.update("jax_enable_x64", True)


def _is_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _raise_interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, but not in JAX's callback of the garbage collector.

    Python would print and ignore an exception there, and the program would continue, so it is
    raised later.
    """
    place = frame
    while place is not None:
        if place.f_code.co_name == "_xla_gc_callback":
            timer = threading.Timer(0.02, signal.raise_signal, (number,))
            timer.daemon = True
            timer.start()
            return
        place = place.f_back
    signal.default_int_handler(number, frame)


@contextlib.contextmanager
def _delay_interrupts() -> Iterator[None]:
    """Delay interrupts inside the block, because they crash Python while compiled modules load."""
    before = signal.getsignal(signal.SIGINT)
    if before is None or not _is_main_thread():
        yield
        return
    caught: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: caught.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if caught:
        signal.raise_signal(signal.SIGINT)
