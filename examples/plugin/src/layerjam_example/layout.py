"""Layout of a machine that separates columns by tildes and marks the end of its file."""

from layerjam.laboratory.measure.readers.layouts import Layout

END = b"#END#"


def read_pipes(data: bytes) -> Layout:
    """Return a file with tildes as a table with semicolons; other files as they are."""
    if not data.rstrip().endswith(END):
        return Layout(data)
    table = data.rstrip().removesuffix(END).replace(b"~", b";")
    return Layout(table, ("columns separated by tildes were read",))
