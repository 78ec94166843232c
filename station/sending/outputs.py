"""Where samples can go; a line here and a file of its own put an output on the list."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from importlib import import_module
from typing import cast

from station.sending.output import BadAddress, Output
from station.sending.samples import About


@dataclass(frozen=True, slots=True)
class OutputKind:
    """How an address begins, how all of it looks, and the module whose ``open_output(where, about)`` opens it."""

    scheme: str
    form: str
    module: str


OUTPUTS = (
    OutputKind("foxglove", "foxglove[:HOST:PORT]", "station.sending.to_foxglove"),
    OutputKind("udp", "udp:HOST:PORT", "station.sending.to_udp"),
    OutputKind("mavlink", "mavlink:udpout:HOST:PORT", "station.sending.to_mavlink"),
    OutputKind("stdout", "stdout", "station.sending.to_stdout"),
)
FORMS = ", ".join(kind.form for kind in OUTPUTS)


def kind_of(text: str) -> OutputKind:
    """Return the kind of an address; raise `BadAddress` if there is none."""
    scheme = text.partition(":")[0]
    for kind in OUTPUTS:
        if kind.scheme == scheme:
            return kind
    raise BadAddress(text, f"no output of that name ({scheme!r})", f"one of {FORMS}")


def open_outputs(addresses: Sequence[str], about: About) -> tuple[Output, ...]:
    """Return the outputs of all addresses; nothing stays open if one is refused."""
    opened = list[Output]()
    with ExitStack() as stack:
        for text in addresses:
            where = text.partition(":")[2]
            opened.append(cast(Output, import_module(kind_of(text).module).open_output(where, about)))
            stack.callback(opened[-1].close)
        stack.pop_all()
    return tuple(opened)
