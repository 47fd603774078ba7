"""First file that runs on a board, before any other file is read.

From here on, Ctrl-C is an ordinary byte on a real board, and a file in flash memory cannot replace
one that is frozen into the image.
"""

import sys

ASKED = 0x4C4A4D54
"""Value of a watchdog scratch register that requests the prompt at the next start."""
SCRATCH = 0x4005800C


def is_prompt_requested() -> bool:
    """Return whether this start should end at the prompt; a reset clears the request."""
    from machine import mem32

    asked = mem32[SCRATCH] == ASKED
    mem32[SCRATCH] = 0
    return asked


maintenance = False
if sys.platform == "rp2":
    maintenance = is_prompt_requested()
    if not maintenance:
        import micropython

        micropython.kbd_intr(-1)
        sys.path[:] = [".frozen", ""]
