"""A bench wholly in memory, for tests and planning: `simulate_campaign` makes a campaign of a unit's truth.

Moves between steps let the clock run and draw new counter remainders, unless they are asked for.
``C_bn`` (3, 3) takes East-North-Up to the cube.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from drivers.simulated.cube_motion import Segment, flip, manual_rotation, rest
from drivers.simulated.effects import Planted, planted
from drivers.simulated.sensor_model import CountingTriads
from drivers.simulated.truth import Truth, World, imu_from_cube
from procedures.arrays import FloatArray
from procedures.campaign.campaign import (
    Campaign,
    DwellRecord,
    FaceCertificate,
    Fixture,
    MoveRecord,
    ProcedureSigma,
    RestRecord,
    Site,
    TurnRecord,
)
from procedures.campaign.plan_steps import Dwell, Monitor, Soak, Step, Turn, turn_steps
from procedures.counts.sample_records import CountSeries
from procedures.frames import AXES, rotation
from procedures.free_positions.free_attitudes import UP_DIRECTIONS, C_bn_of_up, up_vector
from procedures.positions import FACES, face_of

SETTLING_S = 5.0  # of every move, the last seconds are a wait for the cube to settle
MAX_REVOLUTIONS = 100
ALL_POSITIONS = tuple(range(1, 13))


def world_with_effects(truth: Truth) -> World:
    """Return the bench of a truth with its bench and procedure effects in."""
    world = World(
        latitude=float(np.radians(truth.latitude_deg)),
        gravity=truth.local_gravity,
        magnetic_n=truth.magnetic_enu_ut,
        faces=truth.faces_rad,
        slab_tilt=truth.slab_tilt_rad,
        azimuth=truth.slab_azimuth_rad,
        C_sb=imu_from_cube(truth.imu_axes),
    )
    for effect, sizes in planted(truth.effects, truth.terms):
        if effect.world is not None:
            world = effect.world(world, sizes)
    return world


class PoweredUnit:
    """One power-on of a unit on its bench: ``truth``, with the turn-on biases in it, and ``world`` say how it is.

    ``seed`` None: no noise, no scatter of headings and closures. ``also`` are effects that no catalogue holds.
    """

    def __init__(self, truth: Truth, seed: int | None, world: World | None = None, also: Planted = ()) -> None:
        hands, power, care = np.random.SeedSequence(seed or 0).spawn(3)
        self._hands, self._care = np.random.default_rng(hands), np.random.default_rng(care)
        self._scatter = float(seed is not None)
        self.truth = truth if seed is None else truth.powered_on(np.random.default_rng(power))
        self.world = world_with_effects(truth) if world is None else world
        entropy = None if seed is None else [seed]
        self.sensor = CountingTriads(
            self.truth, self.world, (*planted(truth.effects, truth.terms), *also), entropy
        )

    def _draw(self, std_deg: float) -> float:
        return float(np.radians(std_deg) * self._hands.standard_normal() * self._scatter)

    def _placed(self, position: int, *, seated: bool = True) -> FloatArray:
        """Return ``C_bn`` (3, 3) of the cube put into a position, as well as the hands do it."""
        careless, seat = self._care.standard_normal(), self._care.standard_normal(3)
        heading = self._draw(self.truth.heading_std_deg) + self._scatter * self.world.heading_std * careless
        C_bn = self.world.attitude(position, heading, seated)
        return rotation(self._scatter * self.world.seat_std * seat) @ C_bn if self.world.seat_std else C_bn

    def _closure(self) -> float:
        """Return by how much a hand turn ends off where it began [rad]."""
        careless = self._scatter * self.world.closure_std * self._care.standard_normal()
        return self._draw(self.truth.closure_std_deg) + float(careless)


class SimulatedBench(PoweredUnit):
    """Performs steps; headings and closures are drawn per step from the truth's sigmas.

    ``records_moves``: what the unit counts while it is carried from step to step is kept in ``moves``.
    """

    def __init__(
        self, truth: Truth, seed: int | None, move_s: float = 45.0, world: World | None = None,
        also: Planted = (), records_moves: bool = False,
    ) -> None:  # fmt: skip
        super().__init__(truth, seed, world, also)
        self.moves = list[CountSeries]()
        self._records_moves = records_moves
        self._stands: FloatArray | None = None  # C_bn (3, 3) as the last step left it
        self._move = round(move_s / truth.sample_period_s)
        self._wait = round(min(SETTLING_S, move_s) / truth.sample_period_s)
        self._index = 0

    def perform(self, step: Step) -> CountSeries:
        """Do one step and return its counts; device time runs on through the move before it."""
        if not self._records_moves:
            self._move_on()
        match step:
            case Turn():
                return self._turn(step)
            case Dwell() | Monitor():
                return self._dwell(step.position, step.seconds)
            case Soak(position=position) if position:
                return self._dwell(step.position, step.seconds)
            case Soak(up=up) if up:
                return self._dwell(next(p for p in ALL_POSITIONS if face_of(p) == up), step.seconds)
        up_b = up_vector(UP_DIRECTIONS[(step.number - 1) % len(UP_DIRECTIONS)])
        return self._rest(C_bn_of_up(up_b, self._hands.uniform(0, 2 * np.pi)), step.seconds)

    def free(self, C_bn: FloatArray, seconds: float) -> CountSeries:
        """Rest in an attitude ``C_bn`` (3, 3) that is none of the twelve positions."""
        self._move_on()
        return self._rest(C_bn, seconds)

    def _rest(self, C_bn: FloatArray, seconds: float, position: int = 0) -> CountSeries:
        samples = round(seconds / self.truth.sample_period_s)
        self._carry(C_bn)
        return self._record(rest(C_bn, samples, position, self._wait), samples)

    def _carry(self, C_bn: FloatArray) -> None:
        """Carry the cube from where it stands to ``C_bn`` (3, 3), and remember that."""
        if self._records_moves and self._stands is not None:
            moved = flip(self._stands, C_bn, self._move, self.truth.sample_period_s, self._hands)
            self.moves.append(self._record(moved, self._move))
        elif self._records_moves:
            self._move_on()
        self._stands = C_bn

    def _move_on(self) -> None:
        self._index += self._move
        self.sensor.skip()

    def _dwell(self, position: int, seconds: float) -> CountSeries:
        return self._rest(self._placed(position), seconds, position)

    def _turn(self, step: Turn) -> CountSeries:
        C_bn = self._placed(step.start_position, seated=False)
        closure, period = self._closure(), self.truth.sample_period_s
        self._carry(C_bn)
        segment = turn_segment(self.world, C_bn, step, closure, period, self._hands)
        self._stands = segment.end_C_bn()
        return self._record(segment, segment.samples or 0)

    def _record(self, segment: Segment, samples: int) -> CountSeries:
        gyro, accel = self.sensor.counts(segment, self._index, 0, samples)
        ends = np.arange(self._index + 1, self._index + samples + 1, dtype=np.float64)
        t: FloatArray = self.truth.sample_period_s * ends
        self._index += samples
        temperature = self.sensor.temperature(t)
        return CountSeries(t, gyro, accel, temperature, self.truth.sample_period_s)


def turn_segment(
    world: World, C_bn: FloatArray, turn: Turn, closure: float, period: float, rng: np.random.Generator
) -> Segment:
    """Return a hand turn from ``C_bn`` (3, 3) about the slab's normal, ``closure`` [rad] off closing.

    ``turn.direction`` is right-handed about the cube axis, which may point up or down.
    """
    normal_b = C_bn @ world.slab_normal_n()
    if turn.axis not in AXES or turn.direction not in {"+", "-"}:
        raise ValueError(f"turn {turn.axis!r} {turn.direction!r}: expected one of {AXES} and + or -")
    if not 1 <= turn.revolutions <= MAX_REVOLUTIONS:
        raise ValueError(f"turn of {turn.revolutions} revolutions: expected 1 to {MAX_REVOLUTIONS}")
    along = AXES.index(turn.axis)
    if abs(normal_b[along]) < 0.9:
        raise ValueError(
            f"turn about {turn.axis}: that axis is not vertical; place the cube in a position where it is"
        )
    sense = np.sign(normal_b[along]) * (1 if turn.direction == "+" else -1)
    total = float(sense * 2 * np.pi * turn.revolutions + closure)
    return manual_rotation(C_bn, normal_b, total, round(turn.rest_s / period), period, rng, turn.speed_deg_s)


def simulate_campaign(
    truth: Truth,
    seed: int,
    *,
    dwell_s: float = 100.0,
    positions: Iterable[int] = ALL_POSITIONS,
    turns: Iterable[Turn] | None = None,
    repeats: int = 0,
    certificate_sigma: float | None = None,
    gravity_std: float = 1e-5,
    draw_stated: bool = True,
    move_s: float = 45.0,
    free: Iterable[FloatArray] = (),
    also: Planted = (),
    moves: bool = False,
) -> Campaign:
    """Return a whole campaign: dwells, turns (the six of `turn_steps` unless given), then what is named here.

    ``repeats`` dwells in the first position once more, and rests in attitudes; with ``moves`` those between steps.

    The attitudes ``free`` are (3, 3) each, East-North-Up to the cube.

    The campaign states the truth's gravity with ``gravity_std`` [m/s2], its operator sigmas, and, with
    ``certificate_sigma`` [rad], a certificate of all six faces. ``draw_stated``: true gravity is the stated one
    plus a draw of ``gravity_std``, and a certificate is the truth's tilt plus a draw of its sigma; else both are
    exact (a planted site or fixture effect is what they do not state). Headings and closures are always drawn.
    """
    rng = np.random.default_rng([seed, 0xCA17])
    world = world_with_effects(truth)
    gravity_error, face_error = rng.standard_normal(), rng.standard_normal((6, 2))
    if draw_stated:
        world = replace(world, gravity=world.gravity + gravity_std * gravity_error)
    bench = SimulatedBench(truth, seed, move_s, world, also, moves)
    dwells = [Dwell(position, dwell_s) for position in positions]
    faces: dict[str, FaceCertificate] = {}
    if certificate_sigma is not None:
        stated = truth.faces_rad + certificate_sigma * face_error * draw_stated
        covariance = certificate_sigma**2 * np.eye(2)
        faces = {face: FaceCertificate(stated[i], covariance) for i, face in enumerate(FACES)}
    done = [DwellRecord(d.name, d.position, bench.perform(d)) for d in dwells]
    turned = tuple(_turn_record(i, t, bench) for i, t in enumerate(turn_steps() if turns is None else turns))
    for dwell in (replace(dwells[0], repeat=i + 1) for i in range(repeats)):
        done.append(DwellRecord(dwell.name, dwell.position, bench.perform(dwell)))
    stood = [dwell.name for dwell in done[: len(dwells)]] + [turn.name for turn in turned]
    stood += [dwell.name for dwell in done[len(dwells) :]]
    carried = zip(stood, stood[1:], bench.moves, strict=False)
    east, north, up = truth.magnetic_enu_ut.tolist()
    return Campaign(
        model=truth.model,
        serial=truth.serial,
        counts=True,
        site=Site(float(np.radians(truth.latitude_deg)), truth.local_gravity, gravity_std, (east, north, up)),
        dwells=tuple(done),
        turns=turned,
        sigma=ProcedureSigma(float(np.radians(truth.heading_std_deg)), float(np.radians(truth.closure_std_deg))),
        fixture=Fixture(faces, world.C_sb),
        rests=tuple(RestRecord(f"free_{i + 1:02d}", None, bench.free(C, dwell_s)) for i, C in enumerate(free)),
        moves=tuple(MoveRecord(f"move_{i + 1:02d}", a, b, one) for i, (a, b, one) in enumerate(carried)),
    )


def _turn_record(number: int, turn: Turn, bench: SimulatedBench) -> TurnRecord:
    series = bench.perform(turn)
    name = f"{turn.name}_{number + 1}" if turn.speed_deg_s is not None else turn.name
    return TurnRecord(name, turn.axis, turn.direction, turn.revolutions, turn.start_position, series)
