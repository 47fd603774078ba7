"""The console script: how the program begins, and how it ends.

What is loaded (JAX, Matplotlib, compiled code) is neither searched for garbage while it loads nor
taken apart at the end: together that is a second, in which nothing happens that anyone asked for.
"""

from __future__ import annotations

import atexit
import gc
import os
import sys

SELDOM = (200_000, 20, 20)
"""How many objects are made before Python looks for circles among them (usually 700).

A server that stays up goes back to the usual: `workbench.memory.settle`.
"""


def run() -> None:
    """Load the commands, run one, exit with its code.

    An interrupt while the program is still loading is no traceback either.
    """
    gc.set_threshold(*SELDOM)
    ended: list[int] = []
    # what is registered first is called last: nobody else has anything left to do then
    atexit.register(_leave, ended)
    try:
        from layerjam.cli.main import main

        code = main()
    except KeyboardInterrupt:
        print("layerjam: stopped", file=sys.stderr)
        code = 130
    ended.append(code)
    sys.exit(code)


def _leave(ended: list[int]) -> None:
    """End at once with the code in `ended`; Python ends in its own way where there is none."""
    try:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:  # Windows without a console has none
                stream.flush()
    except (OSError, ValueError):  # nobody reads any more
        return
    if ended:
        os._exit(ended[0])
