"""The first file that runs, before any other is read.

On a real board Ctrl-C is a byte like any other from here on, and a file on the flash cannot stand
in for one that is frozen into the image.
"""

import sys

ASKED = 0x4C4A4D54
"""Value of a scratch register of the watchdog if a start is to end at the prompt."""
SCRATCH = 0x4005800C


def prompt_asked() -> bool:
    """Whether this start is to end at the prompt; a reset forgets it."""
    from machine import mem32

    asked = mem32[SCRATCH] == ASKED
    mem32[SCRATCH] = 0
    return asked


maintenance = False
if sys.platform == "rp2":
    maintenance = prompt_asked()
    if not maintenance:
        import micropython

        micropython.kbd_intr(-1)
        sys.path[:] = [".frozen", ""]
