"""Messages of commands, reworded for the page: they name controls instead of flags.

A page's fields are named after their options, without dashes (`Parameter.label`), so most flags
name their control. This module lists flags with a different name, or without a control.
"""

import re
from collections.abc import Mapping

FREE: Mapping[str, str] = {
    "": "nothing more",
    "pressure_exponent": "pressure exponent",
    "speed": "speed",
    "force_offset": "force offset",
}
"""{additional fitted quantity: its name in the laboratory}."""
OTHERWISE: Mapping[str, str] = {
    "accept-stick-slip": "Stick–slip",
    "standard": "Evaluate friction tests as",
    "free": "Also fit (whole curves)",
    "depth": "Calibrate on",
    "no-brake": "No brake",
}
"""{option: name of its control, if it differs}."""
PHRASES = (
    (r"tensile --model stack", "'sheet by sheet' model of a pull"),
    (r"; --tare subtracts it, and depth curves can", "; whole curves can"),
    (r" \(--tare subtracts it\)", ""),
    (r", or give a pattern for its name \(--names '[^']*'\)", ""),
    (r"--standard d1894", "'Evaluate friction tests as', ASTM D1894,"),
    (rf"--free ({'|'.join(filter(None, FREE))})\b", lambda m: f"'Also fit': {FREE[m[1]]}"),
    (r"--from, --to", "'From' and 'To'"),
    (
        r" \(--negative (force|elongation)\)",
        r" (click the \1 header and reverse its sign)",
    ),
    (r" \(--decimal \. or --decimal ,\)", " (choose the decimal separator)"),
    (r" \(--specimen 1\)", " (choose a specimen)"),
    (r" \(--sheet [^)]*\)", " (choose a worksheet)"),
    (r"layerjam (\w[\w-]*) --[a-z-]+", r"layerjam \1"),
)
"""(pattern, replacement) of phrases that contain more than a flag."""
_POWER = re.compile(r"(?<=[A-Za-zµΩ)])\^(-?\d+)")
_TEN = re.compile(r"(?<=\d)e([+-]\d+)(?![\w.])")
_KEY = re.compile(r"(?<![\w./'\"-])[a-z]{2,}(?:_[a-z]{2,})+(?![\w(./'\"-])")
_PATH = re.compile(
    r"(?<![\w./'\"-])(pump|chamber|valve|tube|filter|film|sheets|enclosure|mount|rope|build|site)"
    r"\.([a-z_]+)\b(?![(./])"
)
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PHRASES = tuple((re.compile(pattern), phrase) for pattern, phrase in PHRASES)
_FLAG = re.compile(r"(?<![\w-])--([a-z][a-z0-9]*(?:-[a-z0-9]+)*)")


def typeset_symbols(text: str) -> str:
    """Return typeset text: m² for m^2, 1.2 × 10⁶ for 1.2e+06, ≤ for <=, words for keys."""
    text = _PATH.sub(lambda m: f"{m[1]} {m[2].replace('_', ' ')}", text)
    text = _KEY.sub(lambda m: m[0].replace("_", " "), text)
    text = text.replace(" >= ", " ≥ ").replace(" <= ", " ≤ ")
    text = _POWER.sub(lambda m: m[1].translate(_RAISED), text)
    return _TEN.sub(lambda m: f" × 10{str(int(m[1])).translate(_RAISED)}", text)


def page_text(text: str) -> str:
    """Return a command's message with the names of controls instead of flags."""
    if "--" not in text:
        return text
    for pattern, phrase in _PHRASES:
        text = pattern.sub(phrase, text)
    return _FLAG.sub(lambda m: f"'{control_name(m[1])}'", text)


def typeset_text(text: str) -> str:
    """Return a command's message with the names of controls and typeset units."""
    return typeset_symbols(page_text(text))


def control_name(option: str) -> str:
    """Return the name of an option's control; the option has no dashes."""
    return OTHERWISE.get(option) or option.replace("-", " ").capitalize()


def format_sentence(error: object) -> str:
    """Return an error as one line in the page's terms, without command-line instructions."""
    text, reason = str(error), getattr(error, "reason", "")
    if getattr(error, "asks", "") and reason:
        text = text.replace(reason, str(getattr(error, "plain", reason)))
    return page_text(" ".join(text.split()))
