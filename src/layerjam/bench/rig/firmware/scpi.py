"""SCPI: a tree of headers, their parameters, and the parser of one line.

The nodes of the tree contain the mnemonics; the actions are stored outside their namespace. Error
numbers are those of the standard. After an error, the rest of the line is discarded.
"""

DIGITS = "0123456789"
HEXADECIMAL = "0123456789ABCDEF"
BASES = {"H": 16, "Q": 8, "B": 2}
"""{letter after the # of a non-decimal number: base} (IEEE 488.2, 7.7.4)."""
HEADER = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_:*"
SPACE = " \t"
SUFFIXES = {
    "Pa": {
        "PA": 1.0, "PAL": 1.0, "HPA": 1e2, "HPAL": 1e2, "KPA": 1e3, "KPAL": 1e3, "MBAR": 1e2,
        "BAR": 1e5,
    },
    "s": {"S": 1.0, "MS": 1e-3, "US": 1e-6},
    "Hz": {"HZ": 1.0, "KHZ": 1e3},
    "g": {"G": 1.0},
}  # fmt: skip
"""{SI unit: {suffix in capitals: factor}}."""
TEXTS = {
    0: "No error",
    -101: "Invalid character",
    -104: "Data type error",
    -108: "Parameter not allowed",
    -109: "Missing parameter",
    -113: "Undefined header",
    -114: "Header suffix out of range",
    -131: "Invalid suffix",
    -138: "Suffix not allowed",
    -151: "Invalid string data",
    -203: "Command protected",
    -211: "Trigger ignored",
    -213: "Init ignored",
    -221: "Settings conflict",
    -222: "Data out of range",
    -224: "Illegal parameter value",
    -230: "Data corrupt or stale",
    -241: "Hardware missing",
    -311: "Memory error",
    -314: "Save/recall memory lost",
    -350: "Queue overflow",
    -363: "Input buffer overrun",
}


class ScpiError(Exception):
    """Raised if a line is rejected; its arguments are (number, additional text)."""

    def __init__(self, code: int, detail: str = "") -> None:
        super().__init__(code, detail)
        self.code = code
        self.more = detail


class Node:
    """One mnemonic in the tree: the mnemonics below it, and its own command and query."""

    def __init__(self) -> None:
        self.below: dict[str, Node] = {}
        self.command = None
        self.query = None


class Rule:
    """Action of a header: `do(bench, session, *values)`, its parameters and the allowed states."""

    def __init__(self, do, params: tuple = (), least: int = -1, flags: str = "") -> None:
        self.do = do
        self.params = params
        self.least = len(params) if least < 0 else least
        self.flags = flags


def find_numeral_end(text: str) -> int:
    """Return the length of the decimal number at the start of a text, or 0."""
    size, place, digits = len(text), 0, 0
    if place < size and text[place] in "+-":
        place += 1
    while place < size and text[place] in DIGITS:
        place, digits = place + 1, digits + 1
    if place < size and text[place] == ".":
        place += 1
        while place < size and text[place] in DIGITS:
            place, digits = place + 1, digits + 1
    if not digits:
        return 0
    if place < size and text[place] in "eE":
        end = place + 1
        if end < size and text[end] in "+-":
            end += 1
        first = end
        while end < size and text[end] in DIGITS:
            end += 1
        if end > first:
            place = end
    return place


def parse_non_decimal(text: str) -> "int | None":
    """Return the integer in `#HFF`, `#Q377` or `#B11111111`; None for other text."""
    base = BASES.get(text[1:2].upper(), 0) if text[:1] == "#" else 0
    value = 0
    for letter in text[2:].upper():
        digit = HEXADECIMAL.find(letter)
        if not 0 <= digit < base:
            return None
        value = value * base + digit
    return value if base and text[2:] else None


def resolve_limit(value, bench) -> float:
    """Return a bound; `value` is a number or a function of the bench."""
    return value(bench) if callable(value) else value


class Number:
    """A number from `lo` to `hi` in `unit` ("" means no suffix), or MIN, MAX or DEF.

    `empty` is the message of error -221 if the range is not known yet.
    """

    def __init__(
        self, name: str, unit: str, lo, hi, default=None, is_whole: int = 0, empty: str = ""
    ) -> None:
        self.name, self.unit, self.lo, self.hi = name, unit, lo, hi
        self.default, self.whole, self.empty = default, is_whole, empty

    def resolve_bound(self, word: str, bench) -> object:
        """Return the bound that MIN, MAX or DEF names; None for another word."""
        if word in ("MIN", "MINIMUM"):
            return resolve_limit(self.lo, bench)
        if word in ("MAX", "MAXIMUM"):
            return resolve_limit(self.hi, bench)
        if word in ("DEF", "DEFAULT") and self.default is not None:
            return resolve_limit(self.default, bench)
        return None

    def read(self, text: str, bench) -> object:
        """Return the value in SI units."""
        bound = self.resolve_bound(text.upper(), bench)
        if bound is not None:
            return bound
        integer, suffix = parse_non_decimal(text) if self.whole else None, ""
        value = 0.0 if integer is None else float(integer)
        if integer is None:
            end = find_numeral_end(text)
            if not end:
                raise ScpiError(-104, self.name + " must be a number")
            suffix, value = text[end:].strip().upper(), float(text[:end])
        if suffix:
            if not self.unit:
                raise ScpiError(-138, self.name + " has no unit")
            factor = SUFFIXES[self.unit].get(suffix)
            if factor is None:
                raise ScpiError(-131, self.name + " must be in " + self.unit)
            value *= factor
        lo, hi = resolve_limit(self.lo, bench), resolve_limit(self.hi, bench)
        if not lo <= value <= hi:
            if self.empty and hi <= lo < value:
                raise ScpiError(-221, self.empty)
            raise ScpiError(-222, "%s must be %.9g to %.9g %s" % (self.name, lo, hi, self.unit))
        return int(value + 0.5 if value >= 0 else value - 0.5) if self.whole else value


class Choice:
    """Index of a word in a list, in long or short form (`RELease`); for `OFF|ON` also 0 or 1."""

    def __init__(self, name: str, words: str) -> None:
        self.name = name
        self.words = words.split("|")
        self.known: dict[str, int] = {}
        for place, word in enumerate(self.words):
            self.known[shorten(word)] = self.known[word.upper()] = place
        if words == "OFF|ON":
            self.known["0"], self.known["1"] = 0, 1

    def read(self, text: str, bench) -> object:
        """Return the index of the word."""
        place = self.known.get(text.upper())
        if place is None:
            number = text[:1] in "\"'+-.(#" or (text[:1] in DIGITS and "0" not in self.known)
            raise ScpiError(-104 if number else -224, self.name + " is " + "|".join(self.words))
        return place


class Text:
    """A quoted string of limited length."""

    def __init__(self, name: str, limit: int) -> None:
        self.name, self.most = name, limit

    def read(self, text: str, bench) -> object:
        """Return the text between the quotes, with doubled quotes reduced to single ones."""
        if text[:1] not in ("'", '"'):
            raise ScpiError(-104, self.name + " must be a quoted string")
        if len(text) < 2 or text[-1] != text[0]:
            raise ScpiError(-151, self.name)
        inner = text[1:-1].replace(text[0] * 2, text[0])
        if len(inner) > self.most:
            raise ScpiError(-222, "%s may have at most %d characters" % (self.name, self.most))
        return inner


def shorten(word: str) -> str:
    """Return the short form of a mnemonic: its capitals."""
    return "".join(letter for letter in word if not "a" <= letter <= "z")


def add_header(root: Node, header: str, command, query) -> None:
    """Add a header such as `[SOURce]:VACuum[:LEVel]` to the tree in all of its spellings."""
    nodes = [root]
    for piece in header.replace("[:", ":[").split(":"):
        word = piece.strip("[]")
        children = []
        for node in nodes:
            child = node.below.get(shorten(word)) or Node()
            node.below[shorten(word)] = node.below[word.upper()] = child
            children.append(child)
        nodes = nodes + children if piece[0] == "[" else children
    for node in nodes:
        node.command, node.query = command or node.command, query or node.query


def find_end(line: str, begin: int, mark: str) -> int:
    """Return the position of the first mark outside quotes from `begin` on, or the line's end.

    A loop over the 528 digits of the law's settings would delay a sample, so this uses `find`.
    """
    while True:
        end = line.find(mark, begin)
        end = len(line) if end < 0 else end
        quotes = [
            place
            for place in (line.find("'", begin, end), line.find('"', begin, end))
            if place >= 0
        ]
        if not quotes:
            return end
        first = min(quotes)
        begin = line.find(line[first], first + 1) + 1
        if not begin:
            raise ScpiError(-151, "a quote is not closed")


def split_arguments(text: str) -> list:
    """Return the texts separated by commas that are outside quotes."""
    if not text:
        return []
    out, begin = [], 0
    while begin <= len(text):
        end = find_end(text, begin, ",")
        out.append(text[begin:end].strip(SPACE))
        begin = end + 1
    if "" in out:
        raise ScpiError(-109)
    return out


def split_header(unit: str) -> tuple:
    """Return (header, whether it is a query, the rest) of one message unit."""
    length = 0
    while length < len(unit) and unit[length] in HEADER:
        length += 1
    head, query = unit[:length], unit[length : length + 1] == "?"
    if query:
        length += 1
    if not head or (length < len(unit) and unit[length] not in SPACE) or "*" in head[1:]:
        raise ScpiError(-101, head)
    return head, query, unit[length:].strip(SPACE)


def find_node(root: Node, path: Node, head: str) -> tuple:
    """Return (node of a header, its parent), searching from the root or from `path`."""
    if head[0] == "*":
        if ":" in head:
            raise ScpiError(-101, head)
        node = root.below.get(head.upper())
        if node is None:
            raise ScpiError(-113, head)
        return node, path
    words = head.upper().split(":")
    node = path
    if not words[0]:
        node = root
        words = words[1:]
    above = node
    for word in words:
        if not word:
            raise ScpiError(-101, head)
        # each item exists once, so the suffix 1 means the same as no suffix (SCPI-99, 6.2.5.2)
        plain = word.rstrip(DIGITS)
        above, node = node, node.below.get(word) or node.below.get(plain)
        if node is None:
            raise ScpiError(-113, head)
        if plain != word and int(word[len(plain) :]) != 1:
            raise ScpiError(-114, head)
    return node, above


def read_values(rule: Rule, texts: list, bench) -> list:
    """Return the parsed parameters; raises an error if there are too many or too few."""
    if len(texts) > len(rule.params):
        raise ScpiError(-108)
    if len(texts) < rule.least:
        raise ScpiError(-109, rule.params[len(texts)].name)
    return [param.read(text, bench) for param, text in zip(rule.params, texts)]


def run_line(root: Node, line: bytes, bench, session, pending=None) -> tuple:
    """Execute a line or its `pending` rest; return (response, error or None, had a command).

    The response contains the results of the units before the error. A unit with flag L or C is a
    command. A unit with flag W that must wait goes to `session.held` with the rest of its line.
    """
    out: list[bytes] = []
    text, path, commands = "", root, False
    if pending:
        text, path, out = pending
    try:
        if line and not text and not (min(line) >= 32 and max(line) < 127):
            for byte in line:
                if not 32 <= byte < 127 and byte != 9:
                    raise ScpiError(-101, "byte %d" % byte)
        text = text or str(line, "ascii")
        place, size = 0, len(text)
        while place <= size:
            begin, end = place, find_end(text, place, ";")
            unit = text[place:end].strip(SPACE)
            place = end + 1
            if not unit:
                continue
            head, query, tail = split_header(unit)
            node, path = find_node(root, path, head)
            rule = node.query if query else node.command
            if rule is None:
                raise ScpiError(-113, head)
            bench.check_allowed(session, rule.flags)
            values_read = read_values(rule, split_arguments(tail), bench)
            if "W" in rule.flags and bench.capture.is_busy():
                session.held = text[begin:], path, out
                return b"", None, commands
            answer = rule.do(bench, session, *values_read)
            commands = commands or "L" in rule.flags or "C" in rule.flags
            if answer is not None:
                out.append(answer if isinstance(answer, bytes) else str(answer).encode())
    except ScpiError as error:
        return b";".join(out), error, False
    except MemoryError:
        return b"", ScpiError(-311), False
    # return a single response without a copy, because a block of samples is long
    return out[0] if len(out) == 1 else b";".join(out), None, commands
