"""The mapping file: which signals of a DBC are the IMU's channels, counter, status, check, time and temperature.

docs/how-to/can.md explains every key by an example. A name is ``MESSAGE.SIGNAL``; `counter`, `status` and `check`
may be a bare ``SIGNAL``, which then stands in every message of the sample.
"""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from cantools.database.can import Database, Message
from numpy.typing import NDArray

from drivers.can.dbc_signals import SignalField, field_of, identifier_of, load_dbc
from drivers.can.frame_record import ALL_BITS, pgn_mask
from drivers.errors import BadCanFile

Bytes = NDArray[np.uint8]
Check = Callable[[NDArray[np.uint32], Bytes], Bytes]


def crc8(polynomial: int) -> Check:
    """Return a CRC-8 that begins and ends with FF, nothing reflected."""
    table = np.arange(256)
    for _ in range(8):
        table = (table << 1) ^ np.where(table & 0x80, polynomial, 0)
    octets = table.astype(np.uint8)

    def check(_: NDArray[np.uint32], payloads: Bytes) -> Bytes:
        crc = np.full(len(payloads), 0xFF, dtype=np.uint8)
        for column in payloads.T:
            crc = octets[crc ^ column]
        return crc ^ np.uint8(0xFF)

    return check


def with_identifier(check: Check) -> Check:
    """Return a check over the identifier, as four bytes with the high one first, and then the payload.

    On the bus CAN's own CRC guards an identifier; the text between adapter and station has no check at all.
    """
    return lambda identifiers, payloads: check(
        identifiers, np.hstack((identifiers.astype(">u4").view(np.uint8).reshape(-1, 4), payloads))
    )


def xor8(_: NDArray[np.uint32], payloads: Bytes) -> Bytes:
    """Return the exclusive or (n,) of payloads (n, m) [bytes], without the identifiers ``_`` (n,)."""
    result: Bytes = np.bitwise_xor.reduce(payloads, axis=1)
    return result


CHECKS: dict[str, Check] = {
    "crc8-autosar": crc8(0x2F),  # AUTOSAR CRC8H2F; of the ASCII string 123456789 it is DF
    "crc8-autosar-id": with_identifier(crc8(0x2F)),
    "crc8-j1850": crc8(0x1D),  # SAE J1850; of 123456789 it is 4B
    "xor8": xor8,
}


FORMAT = "can-map/1"
MAX_SOURCE = 0xFD  # the last address that a J1939 device can have: FE is nobody, FF everybody
BY_DBC = "dbc"  # a source address: identifiers are exactly those of the DBC
OUTPUTS = ("increments", "cumulative", "rate")
CHANNELS = ("gx", "gy", "gz", "ax", "ay", "az")
SIGNALS = ("counter", "status", "check", "time", "temperature")
KEYS = {
    "format", "name", "output", "sample_period_s", "gyro", "accel", "counter", "status", "fault_bits", "good_bits",
    "check", "check_kind", "time", "time_unit_s", "temperature", "first", "padded",
    "max_step", "source_address",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Slot:
    """One message of a sample: its identifier (flag of 29 bits included), its length [bytes] and its signals.

    ``channels`` pairs a channel 0..5 with its field. A slot that is not ``is_needed`` comes only now and then.
    Frames belong to it whose identifier agrees in the bits of ``mask``; without those of the source address they
    may come from any one J1939 device, and slots of one ``sender`` (the DBC's address) from the same.
    """

    name: str
    identifier: int
    size: int
    channels: tuple[tuple[int, SignalField], ...]
    counter: SignalField | None
    status: SignalField | None
    check: SignalField | None
    time: SignalField | None
    temperature: SignalField | None
    is_needed: bool
    mask: int = ALL_BITS

    def is_of(self, identifier: int) -> bool:
        """Say whether a frame of ``identifier``, flags included, belongs to it."""
        return (identifier ^ self.identifier) & self.mask == 0

    @property
    def sender(self) -> int | None:
        """The DBC's source address where it is not compared, None where it is."""
        return None if self.mask & 0xFF else self.identifier & 0xFF


@dataclass(frozen=True, slots=True)
class CanMap:
    """A device's frames: ``slots`` of one sample, those needed first.

    ``counts_every_frame``: frames are joined by the counter in each; else by their order, a sample beginning with
    slot ``first``. ``period`` [s] is the nominal one. A status is healthy with none of ``fault_bits`` and all
    of ``good_bits`` set. ``time_unit`` [s] is that of the time signal. ``is_padded``: longer payloads
    are taken too. ``max_step``: a healthy value differs by no more from the last healthy one; None: by anything.
    ``path`` is the mapping file.
    """

    name: str
    title: str
    output: str
    period: float
    slots: tuple[Slot, ...]
    counts_every_frame: bool
    first: int
    fault_bits: int
    good_bits: int
    check_kind: str
    time_unit: float
    is_padded: bool
    max_step: int | None
    path: str = ""

    @property
    def needed(self) -> int:
        """How many frames make a sample."""
        return sum(slot.is_needed for slot in self.slots)

    @property
    def channels(self) -> frozenset[str]:
        """The channels that the device measures."""
        return frozenset(CHANNELS[channel] for slot in self.slots for channel, _ in slot.channels)

    @property
    def counter(self) -> SignalField | None:
        """The sample counter, None where no frame has one."""
        return next((slot.counter for slot in self.slots if slot.counter is not None), None)


def load_map(dbc: str, path: str, period: float | None = None) -> CanMap:
    """Return what a DBC and a mapping file say together; ``period`` [s] stands before the file's.

    Raises `BadCanFile` if either breaks a rule; names the key or signal, what was found and what is accepted.
    """
    try:
        tables = tomllib.loads(Path(path).read_text("utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise BadCanFile(path, None, str(error), "a mapping file in TOML") from error
    return _Reading(load_dbc(dbc), dbc, path, tables).map(period)


class _Reading:
    """One mapping file being read."""

    def __init__(self, database: Database, dbc: str, path: str, tables: Mapping[str, Any]) -> None:
        self._messages = {message.name: message for message in database.messages}
        self._dbc, self._path, self._tables = dbc, path, tables

    def map(self, period: float | None) -> CanMap:
        if self._tables.get("format") != FORMAT:
            raise self._refused(f"format = {self._tables.get('format')!r}", repr(FORMAT))
        if unknown := sorted(set(self._tables) - KEYS):
            raise self._refused(f"key {unknown[0]!r}", ", ".join(sorted(KEYS)))
        channels = [*self._triad("gyro", 0), *self._triad("accel", 3)]
        if not channels:
            raise self._refused("neither gyro nor accel", "either, or both: three names MESSAGE.SIGNAL each")
        named = {key: self._names(key) for key in SIGNALS}
        needed = [message.name for _, message, _ in channels]
        needed += [name for key in SIGNALS[:-1] for name in named[key] if name]
        names = dict.fromkeys([*needed, *named["temperature"]])
        slots = tuple(self._slot(self._message(name), channels, named, name in needed) for name in names)
        by_counter = bool(self._text("counter")) and "." not in self._text("counter")
        return CanMap(
            name=self._text("name") or Path(self._path).stem,
            title=f"{Path(self._dbc).name} as {Path(self._path).name} reads it",
            output=self._one_of("output", OUTPUTS),
            period=self._number("sample_period_s", 1e-5, 10.0) if period is None else period,
            slots=slots,
            counts_every_frame=by_counter,
            first=0 if by_counter else self._first(slots),
            fault_bits=self._whole("fault_bits"),
            good_bits=self._whole("good_bits"),
            check_kind=self._one_of("check_kind", CHECKS) if self._text("check") else "",
            time_unit=self._number("time_unit_s", 1e-12, 1.0) if self._text("time") else 1.0,
            is_padded=self._tables.get("padded", False) is True,
            max_step=self._whole("max_step") or None,
            path=self._path,
        )

    def _refused(self, found: str, expected: str) -> BadCanFile:
        return BadCanFile(self._path, None, found, expected)

    def _text(self, key: str) -> str:
        value = self._tables.get(key, "")
        if not isinstance(value, str):
            raise self._refused(f"{key} = {value!r}", "a text")
        return value

    def _one_of(self, key: str, accepted: Mapping[str, object] | tuple[str, ...]) -> str:
        if (value := self._text(key)) not in accepted:
            raise self._refused(f"{key} = {value!r}", f"one of {', '.join(accepted)}")
        return value

    def _number(self, key: str, low: float, high: float) -> float:
        value = self._tables.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
            raise self._refused(f"{key} = {value!r}", f"a number from {low:g} to {high:g}")
        return float(value)

    def _whole(self, key: str) -> int:
        value = self._tables.get(key, 0)
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**63:
            raise self._refused(f"{key} = {value!r}", "a whole number, not negative")
        return value

    def _triad(self, key: str, first: int) -> list[tuple[int, Message, SignalField]]:
        """Return the channels from ``first`` on with their signals; none of a sensor that the device lacks."""
        if key not in self._tables:
            return []
        names = self._tables[key]
        if not isinstance(names, list) or len(names) != 3 or not all(isinstance(each, str) for each in names):
            raise self._refused(f"{key} = {names!r}", "three names MESSAGE.SIGNAL, those of x, y, z")
        found = [self._signal(each) for each in names]
        for name, (_, field) in zip(names, found, strict=True):
            is_whole = not field.is_float and (field.bits < 64 or field.is_signed)
            if not is_whole and self._text("output") != "rate":
                raise self._refused(f"{key} {name}, which is no whole number of up to 64 bits", "a count")
        return [(first + i, *signal) for i, signal in enumerate(found)]

    def _signal(self, name: str) -> tuple[Message, SignalField]:
        message, dot, signal = name.partition(".")
        if not dot:
            raise self._refused(f"{name!r}", "a name MESSAGE.SIGNAL")
        return self._message(message), field_of(self._dbc, self._message(message), signal)

    def _message(self, name: str) -> Message:
        if name not in self._messages:
            raise self._refused(f"message {name!r}", f"one of {', '.join(self._messages)} of {self._dbc}")
        return self._messages[name]

    def _names(self, key: str) -> dict[str, str]:
        """Return a key's signal by message; by the empty name where it stands in every one."""
        text = self._text(key)
        message, dot, signal = text.partition(".")
        if text and not dot and key in {"time", "temperature"}:
            raise self._refused(f"{key} = {text!r}", "a name MESSAGE.SIGNAL")
        return {message: signal} if dot else {"": text} if text else {}

    def _slot(
        self,
        message: Message,
        channels: list[tuple[int, Message, SignalField]],
        named: dict[str, dict[str, str]],
        is_needed: bool,
    ) -> Slot:
        fields: dict[str, SignalField | None] = dict.fromkeys(SIGNALS)
        for key in SIGNALS:
            if signal := named[key].get(message.name) or named[key].get(""):
                fields[key] = field_of(self._dbc, message, signal)
        if (check := fields["check"]) is not None and (check.bits != 8 or check.shift % 8):
            raise self._refused(f"check in {message.name} of {check.bits} bits", "a whole byte")
        identifier, mask = self._identifier(message)
        return Slot(
            name=message.name,
            identifier=identifier,
            mask=mask,
            size=message.length,
            channels=tuple((i, each) for i, owner, each in channels if owner is message),
            is_needed=is_needed,
            **fields,
        )

    def _identifier(self, message: Message) -> tuple[int, int]:
        """Return a message's identifier and which of its bits frames must agree in."""
        own, source = identifier_of(message), self._tables.get("source_address")
        address = source if isinstance(source, int) and not isinstance(source, bool) else -1
        if source not in {None, BY_DBC} and not 0 <= address <= MAX_SOURCE:
            raise self._refused(
                f"source_address = {source!r}",
                f"an address from 0 to {MAX_SOURCE} (0x{MAX_SOURCE:X}) or {BY_DBC!r}",
            )
        mask = pgn_mask(own)
        if mask == ALL_BITS or source == BY_DBC:
            return own, ALL_BITS
        if source is not None:
            return own & ~0xFF | address, mask | 0xFF
        others = (identifier_of(each) for each in self._messages.values() if each is not message)
        is_shared = any((other ^ own) & mask == 0 for other in others)  # the other bits distinguish them
        return own, ALL_BITS if is_shared else mask

    def _first(self, slots: tuple[Slot, ...]) -> int:
        names = [slot.name for slot in slots if slot.is_needed]
        if (name := self._text("first")) not in names:
            raise self._refused(f"first = {name!r} and no counter in every frame", f"one of {', '.join(names)}")
        return names.index(name)
