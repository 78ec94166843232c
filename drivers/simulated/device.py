"""The simulated device: an IMU, a wire format and its faults, as a sequence of what goes over the line.

A command acts on the first sample not yet taken; at equal device times equal seeds give equal bytes.
"""

from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from threading import Lock
from typing import NamedTuple

import numpy as np

from drivers.errors import TruthRefused
from drivers.simulated.faults import Fault, FaultyLine, Sent
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack
from drivers.wire import FORMATS, Identity, WireFormat
from procedures.arrays import FloatArray
from procedures.counts.sample_records import CountBlock

MAX_CHUNK_SAMPLES = 50  # of a chunk: bounds how late a command acts
IDENTITY_EVERY_S = 1.0


class ScheduledMove(NamedTuple):
    """A command to the hands at a device time [s], exact to the sample."""

    at_s: float
    command: str


class ByteDevice:
    """What a device says, chunk by chunk, and the hands that move it.

    ``moves`` are what the hands do by themselves, in order of time; ``moved`` what they answered to those done.
    ``pps``: a pulse at each whole second of true time is at its input, and its samples report it.
    """

    def __init__(
        self,
        truth: Truth,
        seed: int | None,
        format: str | WireFormat,
        faults: Iterable[Fault] = (),
        moves: Iterable[ScheduledMove] = (),
        *,
        pps: bool = False,
    ) -> None:
        self.imu = SimulatedImu(truth, seed)
        self.truth = self.imu.truth
        wire = FORMATS[format] if isinstance(format, str) else format
        if pps:
            wire = pulsed(wire, self.imu.world.clock_ppm)
        period = truth.sample_period_s
        self._faulty = FaultyLine(wire, faults, period, seed or 0)
        self._sends_rates = wire.output == "rate"
        self._identity = b""
        if wire.encode_identity is not None:
            self._identity = wire.encode_identity(Identity(truth.model, truth.serial, period))
        self._every = max(1, round(IDENTITY_EVERY_S / period))
        self._lock = Lock()
        self._moves = deque((round(move.at_s / period), move.command) for move in moves)
        self.moved: list[tuple[str, str]] = []

    @property
    def samples(self) -> int:
        """Samples taken since power-on."""
        return self.imu.index

    def chunk(self, most: int = MAX_CHUNK_SAMPLES) -> list[Sent]:
        """Take up to ``most`` samples and return what goes over the line for them."""
        with self._lock:
            self._move()
            since = self.imu.index % self._every
            next_move = self._moves[0][0] - self.imu.index if self._moves else most
            samples = min(most, self._every - since, next_move)
            block = self.imu.read_rates(samples) if self._sends_rates else self.imu.read(samples)
        text = self._faulty.announce(self._identity) if since == 0 else []
        return [*text, *self._faulty.send(block)]

    def execute(self, command: str) -> str:
        """Do what a line says and return the answer, ``ok ...`` or ``error ...``; never raises."""
        with self._lock:
            return self._answer(command)

    def drive(self, track: VehicleTrack) -> None:
        """Carry the cube along a track from now on, see `SimulatedImu.drive`."""
        with self._lock:
            self.imu.drive(track)

    def plant(self, kind: str, count: int = 1, seconds: float = 1.0) -> None:
        """Have a fault act on the first sample not yet taken, see `drivers.simulated.faults.KINDS`."""
        with self._lock:
            self._faulty.plant(Fault(kind, self.imu.time, count=count, seconds=seconds))

    def _move(self) -> None:
        while self._moves and self._moves[0][0] <= self.imu.index:
            _, command = self._moves.popleft()
            self.moved.append((command, self._answer(command)))

    def _answer(self, command: str) -> str:
        try:
            return f"ok {self._execute(command.split())}".rstrip()
        except ValueError as error:
            return f"error {error}".replace("\n", " ")

    def _execute(self, words: list[str]) -> str:
        imu = self.imu
        match words:
            case ["place", position]:
                imu.place(int(position))
            case ["place", position, move_s, *off_deg] if len(off_deg) in {0, 3}:
                imu.place(int(position), float(move_s), _rad(off_deg) if off_deg else None)
            case ["carry", position, *seconds] if len(seconds) in {2, 3}:
                imu.carry(int(position), *map(float, seconds))
            case ["tilt" | "lean", x, y, z, *move_s] if len(move_s) < 2:
                imu.tilt(np.array([float(x), float(y), float(z)]), *map(float, move_s))
            case ["heat", kelvin, tau_s]:
                imu.heat(float(kelvin), float(tau_s))
            case ["shock" | "knock", seconds, size_g]:
                imu.shock(float(seconds), float(size_g))
            case ["creep", seconds, *turn_deg] if len(turn_deg) == 3:
                imu.creep(float(seconds), _rad(turn_deg))
            case ["turn", axis, direction, revolutions, *rest_s] if len(rest_s) < 2:
                imu.turn(axis, direction, int(revolutions), *map(float, rest_s))
            case ["rest", seconds]:
                imu.rest(float(seconds))
            case ["time"]:
                return f"{imu.time:.6f}"
            case ["status"]:
                state = "moving" if imu.is_moving else "resting"
                return f"position {imu.position} {state} time {imu.time:.6f} done {imu.done:.6f}"
            case _:
                raise ValueError(
                    f"unknown command {' '.join(words)!r}; expected place POSITION [MOVE_S "
                    "[X_DEG Y_DEG Z_DEG]], carry POSITION MOVE_S TREMOR_DEG_S [PAUSE_S], "
                    "tilt X Y Z [MOVE_S], turn AXIS + or - REVOLUTIONS [REST_S], "
                    "rest SECONDS, heat KELVIN TAU_S, "
                    "shock SECONDS SIZE_G, creep SECONDS X_DEG Y_DEG Z_DEG, status, time or go"
                )
        return f"time {imu.time:.6f} done {imu.done:.6f}"


def pulsed(wire: WireFormat, clock_ppm: float) -> WireFormat:
    """Return a format whose samples report how long before them a pulse of true time came, by the device's clock.

    Raises `TruthRefused` if the format reports no pulse.
    """
    pulse, pace = wire.pulse, 1 + 1e-6 * clock_ppm
    if pulse is None:
        has = ", ".join(name for name, each in FORMATS.items() if each.pulse is not None)
        raise TruthRefused(f"a pulse with format {wire.name}", f"a format that reports one: {has}")

    def with_pulses(block: CountBlock) -> bytes:
        return pulse.mark(block, (block.device_time / pace) % 1.0 * pace)

    return replace(wire, encode=with_pulses)


def _rad(degrees: list[str]) -> FloatArray:
    vector: FloatArray = np.radians([float(each) for each in degrees])
    return vector
