"""The headers of the accelerometer's record and its trigger."""

import binascii

from capture import READ
from common import block, setting
from scpi import Choice, Number, Rule


def rate(bench, session, value: int) -> None:
    bench.capture.at_rest()
    bench.capture.rate = value


def rate_now(bench) -> int:
    return bench.capture.rate


def before(bench, session, time: float) -> None:
    bench.capture.at_rest()
    bench.capture.before = time


def before_now(bench) -> float:
    return bench.capture.before


def after(bench, session, time: float) -> None:
    bench.capture.at_rest()
    bench.capture.after = time


def after_now(bench) -> float:
    return bench.capture.after


def level(bench, session, value: float) -> None:
    bench.capture.at_rest()
    bench.capture.level = value


def level_now(bench) -> float:
    return bench.capture.level


def fall(bench, session, time: float) -> None:
    bench.capture.at_rest()
    bench.capture.fall = time


def fall_now(bench) -> float:
    return bench.capture.fall


def source(bench, session, place: int) -> None:
    bench.capture.at_rest()
    bench.capture.source = place


def source_now(bench, session) -> str:
    return ("IMM", "BUS", "ACC", "EXT")[bench.capture.source]


def start(bench, session) -> None:
    bench.capture.start()


def state(bench, session) -> str:
    return bench.capture.shown()


def scale(bench, session) -> str:
    return '"%s"' % str(binascii.hexlify(bench.capture.scaled()), "ascii").upper()


def data(bench, session, first: int, count: int) -> bytes:
    return block(bench.capture.data(first, count))


CAPTURE = [
    setting(
        "SENSe:ACCeleration:RATE",
        Number("rate", "Hz", 500, 20000, 8000, whole=1),
        rate,
        rate_now,
        "SL",
    ),
    setting("SENSe:ACCeleration:PRE", Number("pre", "s", 0.0, 0.5, 0.1), before, before_now, "SL"),
    setting("SENSe:ACCeleration:POST", Number("post", "s", 0.01, 1.5, 0.5), after, after_now, "SL"),
    (
        "TRIGger:SOURce",
        Rule(source, (Choice("source", "IMMediate|BUS|ACCeleration|EXTernal"),), flags="L"),
        Rule(source_now),
    ),
    setting("TRIGger:LEVel", Number("level", "g", 0.5, 200.0, 5.0), level, level_now, "L"),
    setting("TRIGger:FALL", Number("fall", "s", 0.0, 0.5, 0.03), fall, fall_now, "L"),
    ("INITiate", Rule(start, flags="L"), None),
    ("FETCh:ACCeleration:STATe", None, Rule(state)),
    ("FETCh:ACCeleration:SCALe", None, Rule(scale)),
    (
        "FETCh:ACCeleration:DATA",
        None,
        Rule(
            data,
            (Number("first", "", 0, 16383, whole=1), Number("samples", "", 1, READ, whole=1)),
        ),
    ),
]
