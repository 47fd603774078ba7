"""Settings of an accelerometer record: rate, duration and trigger."""

from layerjam.core.units import QuantitySpec

SOURCES = {"immediate": "IMM", "bus": "BUS", "acceleration": "ACC", "external": "EXT"}
"""{trigger: its SCPI keyword}."""
RATE = QuantitySpec("Hz", "accelerometer samples per second", lo=500, hi=20000, whole=True)
BEFORE = QuantitySpec("s", "time kept before the trigger", lo=0, hi=0.5)
AFTER = QuantitySpec("s", "time kept after the trigger", lo=0.01, hi=1.5)
FALL = QuantitySpec("s", "free-fall time that arms the trigger; 0 if none is needed", lo=0, hi=0.5)
LEVEL = QuantitySpec(
    "1", "acceleration that triggers, in g above that of free fall", lo=0.5, hi=200, example="3"
)
