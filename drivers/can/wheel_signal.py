"""A wheel's speed on CAN: one signal of a DBC, of any message, in a unit of speed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.can.dbc_signals import SignalField, field_of, identifier_of, load_dbc, payloads_of, words_of
from drivers.can.frame_record import (
    ALL_BITS,
    EXTENDED,
    IMU,
    NO_DATA_FRAME,
    NULL_ADDRESS,
    RECORD,
    SOURCE,
    SenderWatch,
    WheelReading,
    pack,
    pgn_mask,
)
from drivers.errors import BadCanFile
from drivers.wire.counts import is_intact
from procedures.units import M_S_PER_KM_H, M_S_PER_KNOT, M_S_PER_MPH

UNITS = {  # m/s, as DBCs spell them, without case and spaces
    "m/s": 1.0, "mps": 1.0, "cm/s": 0.01, "mm/s": 0.001,
    "km/h": M_S_PER_KM_H, "kph": M_S_PER_KM_H, "kmh": M_S_PER_KM_H, "km/hour": M_S_PER_KM_H,
    "mph": M_S_PER_MPH, "mi/h": M_S_PER_MPH, "mile/h": M_S_PER_MPH,
    "kn": M_S_PER_KNOT, "kt": M_S_PER_KNOT, "knots": M_S_PER_KNOT,
}  # fmt: skip
MAX_SPEED_M_S = 150.0  # m/s: what is beyond is no vehicle's, whatever the DBC says


@dataclass(frozen=True, slots=True)
class WheelSignal:
    """Where it stands: in frames of ``identifier`` and at least ``size`` bytes; ``factor`` makes it m/s.

    Where the DBC names no sender (J1939's null address) frames of the same PGN count, from any one device.
    """

    identifier: int
    size: int
    field: SignalField
    factor: float
    dbc: str = ""

    @property
    def mask(self) -> int:
        """The bits of an identifier that frames must agree in."""
        return pgn_mask(self.identifier) if self.identifier & SOURCE == NULL_ADDRESS else ALL_BITS

    def frame(self, speed: float, host_ns: int) -> bytes:
        """Return the record of a frame that carries a speed [m/s]."""
        raw = np.rint((speed / self.factor - self.field.offset) / self.field.scale)
        words = np.zeros(1, np.uint64), np.zeros(1, np.uint64)
        self.field.put(words, np.array([raw], dtype=np.int64))
        return pack(self.identifier, host_ns, payloads_of(words)[0].tobytes()[: self.size])


def wheel_signal(dbc: str, name: str, unit: str = "") -> WheelSignal:
    """Return where a signal ``MESSAGE.SIGNAL`` of a DBC stands; ``unit`` stands before the DBC's.

    Raises `BadCanFile` if the DBC is none, there is no such message or signal, or its unit is none of a speed.
    """
    messages = {message.name: message for message in load_dbc(dbc).messages}
    message, dot, signal = name.partition(".")
    if not dot:
        raise BadCanFile(dbc, None, f"signal {name!r}", "a name MESSAGE.SIGNAL")
    if message not in messages:
        raise BadCanFile(dbc, None, f"no message {message!r}", f"one of {', '.join(messages)}")
    field = field_of(dbc, messages[message], signal)
    found_unit = unit or field.unit
    factor = UNITS.get("".join(found_unit.lower().split()))
    if factor is None:
        found = f"{name} in {found_unit!r}" if found_unit else f"{name} without a unit"
        raise BadCanFile(dbc, None, found, f"a unit of speed, or unit= one of {', '.join(UNITS)}")
    return WheelSignal(identifier_of(messages[message]), messages[message].length, field, factor, dbc)


class WheelDecoder:
    """Bytes of a CAN port to readings. ``frames``, ``refused`` and ``bad`` count: those of the signal, those of
    them that carried no speed, and records that were damaged.
    """  # noqa: D205

    def __init__(self, signal: WheelSignal) -> None:
        self._signal, self._rest = signal, b""
        self._watch = SenderWatch(signal.dbc, "write the sender's address, {}, into the identifier there")
        self.frames = self.refused = self.bad = 0

    def feed(self, data: bytes, host_ns: int) -> list[WheelReading]:
        """Return the readings in bytes that were read at ``host_ns`` [ns]."""
        records = self._records(data)
        if not len(records):
            return []
        newest = int(records["host_ns"][-1])
        is_of = (records["id"] ^ np.uint32(self._signal.identifier)) & np.uint32(self._signal.mask) == 0
        ours = records[is_of & (records["size"] >= self._signal.size)]
        if len(ours) and self._signal.mask != ALL_BITS:
            self._watch.look(NULL_ADDRESS, ours["id"])
        words, field = words_of(ours["data"]), self._signal.field
        speed = field.value(words) * self._signal.factor
        is_known = field.is_known(words, by_j1939=bool(self._signal.identifier & EXTENDED))
        is_good = is_known & (np.abs(speed) <= MAX_SPEED_M_S)
        self.frames += len(ours)
        self.refused += int(np.count_nonzero(~is_good))
        # frames of one read came one after another: each is as much older as its port says
        at = host_ns - np.clip(newest - ours["host_ns"][is_good], 0, 10**9)
        found = zip(at.tolist(), speed[is_good].tolist(), strict=True)
        return [WheelReading(each_ns, value, read_ns=host_ns) for each_ns, value in found]

    def _records(self, data: bytes) -> NDArray[np.void]:
        """Return the data frames in what has come, whole and intact."""
        self._rest += data
        found = list[bytes]()
        while (at := self._rest.find(IMU.prefix)) >= 0 and len(self._rest) - at >= RECORD.itemsize:
            record = self._rest[at : at + RECORD.itemsize]
            intact = is_intact(record)
            self.bad += not intact
            found += [record] if intact else []
            self._rest = self._rest[at + (RECORD.itemsize if intact else len(IMU.prefix)) :]
        self._rest = self._rest[-RECORD.itemsize :] if at < 0 else self._rest
        records: NDArray[np.void] = np.frombuffer(b"".join(found), RECORD)
        data_frames: NDArray[np.void] = records[(records["id"] & NO_DATA_FRAME) == 0]
        return data_frames
