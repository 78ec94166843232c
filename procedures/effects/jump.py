"""What changes from one moment on: jumps of a bias or scale factor, turn-on biases, a tilted unit."""

import itertools
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal, TypeVar, overload

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Effect
from procedures.effects.excitation import ALONG, Columns, Excitation, ExcitationStep, per_axis, rotation_columns
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S, PPM_PER_ONE, UG_PER_G

SCALE_PPM = 100.0  # plausible
UNCALIBRATED = 0.02  # of gravity, that biases and scale factor errors of accelerometers nobody calibrated come to
SLIP = 1e-4  # rad, plausible: 0.01 mm on 100 mm; beyond ten times that something else is wrong
RESTING = ("dwell", "rest", "soak")
MAX_PLACES = 200  # that are tried: of more, as in many soaks together, evenly spread ones
MIN_STEPS = 2  # on either side: one step by itself is no jump
PARTS = 8  # of a rest, in the middle of each of which a jump is tried: then its time is known to a sixteenth of it
PARTS_OF_MOVE = 2  # the same, of a move: to 6 s, in which 0.5 deg/h turn by 3 arcsec, as seats leave open

BlockTimes = dict[ExcitationStep, tuple[float, float]]
Place = TypeVar("Place")


def places(excitation: Excitation, *, moves: bool = False) -> list[tuple[ExcitationStep, FloatArray]]:
    """Return the step before each place, and 1 at the nodes (n,) after it in its campaign, else 0.

    With ``moves`` also before each move. Of more than `MAX_PLACES` they are every so many: a jump in between is
    seen at its neighbour, a step or two off, and each place that is tried counts.
    """
    begins, history = _begins(excitation), excitation.histories
    pairs = list[tuple[int, int, int]]()
    for one, order in _orders(excitation, begins):
        stood = np.cumsum([excitation.steps[number].kind != "move" for number in order])
        tried = [n for n in range(len(order)) if moves or excitation.steps[order[n]].kind != "move"]
        for before, after in itertools.pairwise(tried):
            if MIN_STEPS <= stood[before] <= stood[-1] - MIN_STEPS:
                pairs.append((one, order[before], order[after]))
    found = list[tuple[ExcitationStep, FloatArray]]()
    for one, before, after in _evenly(pairs, MAX_PLACES):
        later = (history[excitation.step] == one) & (begins[excitation.step] >= begins[after])
        found.append((excitation.steps[before], later.astype(float)))
    return found


def places_within(
    excitation: Excitation, *, moves: bool = False
) -> list[tuple[ExcitationStep, float, FloatArray]]:
    """Return the step of each place within a rest, seconds since it began, and 1 at the nodes (n,) after it.

    Not of the first and the last one of a campaign, which are one side of it by themselves. Of many they are fewer
    in each, of more than `MAX_PLACES` the middle of every so many. With ``moves`` also within each move.
    """
    history, found = excitation.histories, list[tuple[ExcitationStep, float, FloatArray]]()
    inner, moved = list[int](), list[int]()
    for _, order in _orders(excitation, _begins(excitation)):
        inner += [number for number in order if excitation.steps[number].kind != "move"][1:-1]
        moved += [number for number in order if moves and excitation.steps[number].kind == "move"]
    inner = _evenly([number for number in inner if excitation.steps[number].kind in RESTING], MAX_PLACES)
    parts = min(PARTS, MAX_PLACES // max(len(inner), 1))
    tried = [(number, parts) for number in inner]
    tried += [(number, PARTS_OF_MOVE) for number in _evenly(moved, MAX_PLACES // PARTS_OF_MOVE)]
    for number, most in tried:
        step, t = excitation.steps[number], excitation.t[excitation.step == number]
        parts = min(most, len(t) - 1)  # between its nodes: more of them would be the same
        for part in range(parts):
            at = float(t[0] + (part + 0.5) / parts * (t[-1] - t[0]))
            later = (history[excitation.step] == history[number]) & (excitation.t > at)
            since = at - float(t[0]) + float(t[1] - t[0]) / 2  # nodes are in the middle of what they stand for
            found.append((step, since, later.astype(float)))
    return found


def _orders(excitation: Excitation, begins: FloatArray) -> Iterator[tuple[int, list[int]]]:
    """Yield each history and its steps' numbers in the order of time; ``begins`` (m,) [s] is of each step."""
    history = excitation.histories
    for one in np.unique(history):
        numbers = [n for n in range(len(begins)) if history[n] == one and np.isfinite(begins[n])]
        yield int(one), sorted(numbers, key=lambda number: begins[number])


def _evenly(what: list[Place], most: int) -> list[Place]:
    """Return every so many of a list, at most so many."""
    return what[:: -(-len(what) // most) or 1]


def _begins(excitation: Excitation) -> FloatArray:
    """Return when each step begins (m,) [s], nan of one without nodes."""
    times = [excitation.t[excitation.step == step] for step in range(len(excitation.steps))]
    return np.array([float(t[0]) if len(t) else np.nan for t in times])


class Jumps(Sequence[Columns]):
    """The ways, made when they are asked for: with moves each has megabytes, and there are hundreds."""

    def __init__(self, made: Sequence[Callable[[], Columns]]) -> None:
        self._made = made

    def __len__(self) -> int:
        return len(self._made)

    @overload
    def __getitem__(self, i: int) -> Columns: ...
    @overload
    def __getitem__(self, i: slice) -> "Jumps": ...
    def __getitem__(self, i: int | slice) -> "Columns | Jumps":
        return Jumps(self._made[i]) if isinstance(i, slice) else self._made[i]()


def accelerometer_columns(excitation: Excitation) -> Jumps:
    """Return a jump of bias, and between steps one of scale factor, at every place [g per g, per ppm]."""
    return Jumps(_columns(excitation, "accel", excitation.accel_output, 1.0, 1e-4))


def gyroscope_columns(excitation: Excitation) -> Jumps:
    """Return a jump of bias, and between steps one of scale factor, at every place [deg/s per deg/h, per ppm]."""
    return Jumps(_columns(excitation, "gyro", excitation.gyro_output, 1 / DEG_H_PER_DEG_S, 0.5))


def _columns(
    excitation: Excitation, acts_on: str, output: FloatArray, per: float, plausible: float
) -> list[Callable[[], Columns]]:
    found = list[Callable[[], Columns]]()
    moves, blocks = acts_on == "gyro", block_times(excitation)

    def placed(way: Columns, later: FloatArray, by: FloatArray | float) -> Columns:
        column = per_axis(later[:, None] * by if isinstance(by, np.ndarray) else later * by)
        return replace(way, accel=column) if acts_on == "accel" else replace(way, gyro=column)

    for step, later in places(excitation, moves=moves):
        bias = Columns(AXES, where=place_after(excitation, step, blocks), shape="bias", plausible=(plausible,) * 3)
        scale = replace(bias, shape="scale factor", unit="ppm", plausible=(SCALE_PPM,) * 3)
        found.append(partial(placed, bias, later, per))
        if step.kind != "soak":  # at one attitude it is a bias
            found.append(partial(placed, scale, later, output / PPM_PER_ONE))
    for step, seconds, later in places_within(excitation, moves=moves):
        where = place_within(excitation, step, seconds, blocks)
        within = Columns(AXES, where=where, shape="bias", plausible=(plausible,) * 3)
        found.append(partial(placed, within, later, per))
    return found


def block_times(excitation: Excitation) -> BlockTimes:
    """Return when each block of a soak begins in it, and how long it lasts [s]; a node is in the middle."""
    found, ended = BlockTimes(), defaultdict[tuple[int, str], float](float)
    for number, step in enumerate(excitation.steps):
        if step.kind == "soak":
            t, soak = excitation.t[excitation.step == number], (step.campaign, soak_of(step))
            lasts = float(t[-1] - t[0]) * len(t) / (len(t) - 1) if len(t) > 1 else 0.0
            found[step] = ended[soak], lasts
            ended[soak] += lasts
    return found


def place_after(excitation: Excitation, step: ExcitationStep, blocks: BlockTimes) -> dict[str, object]:
    """Return where a place after a step is: of a soak, which has no steps for its reader, the time in it [s]."""
    if step.kind == "soak":
        return place_within(excitation, step, blocks[step][1], blocks)
    return {"after": step.name, **_campaign_of(excitation, step)}


def place_within(
    excitation: Excitation, step: ExcitationStep, seconds: float, blocks: BlockTimes
) -> dict[str, object]:
    """Return where a place is, ``seconds`` after a step began; of a soak since the soak began."""
    if step.kind != "soak":
        return {"in": step.name, "after_s": round(seconds, 1), **_campaign_of(excitation, step)}
    since = blocks[step][0] + seconds
    return {"in": soak_of(step), "after_s": round(since, 1), **_campaign_of(excitation, step)}


def soak_of(step: ExcitationStep) -> str:
    """Return the name of the soak that a block is of."""
    return step.name.rpartition(" block ")[0]


def _campaign_of(excitation: Excitation, step: ExcitationStep) -> dict[str, object]:
    """Return the number of a step's campaign, from 1, where there are several: their files may share names."""
    several = len({one.campaign for one in excitation.steps}) > 1
    return {"campaign": step.campaign + 1} if several else {}


ACCELEROMETER_JUMP = Effect(
    name="accelerometer.jump",
    meaning="Jump of a bias or scale factor",
    of_shape={"bias": "Jump of a bias", "scale factor": "Jump of a scale factor"},
    about=(
        "c or 1e-6 c u in every step after it. Where the unit was switched off and on in between it is its "
        "turn-on bias. Each place between two neighbouring steps of a campaign is a way of its own, to "
        "gyroscopes before a move and after it, and of the bias each of some places within a rest or a move: "
        "half of all jumps come while the cube rests. Plausible: 100 ug and 0.5 deg/h, 100 ppm."
    ),
    unit="g",
    physics="c, or 1e-6 c u, in every step after one",
    source="IEEE Std 1293, bias and scale factor repeatability",
    plausible=1e-4,
    columns=accelerometer_columns,
    next_measurement="repeat",
    separate_by="the first position again at the end, and the campaign once more without switching off",
    driver="time",
)
GYROSCOPE_JUMP = replace(
    ACCELEROMETER_JUMP,
    name="gyroscope.jump",
    unit="deg/h",
    source="IEEE Std 952, bias and scale factor repeatability",
    plausible=0.5,
    columns=gyroscope_columns,
)


def _turn_on(acts_on: Literal["accel", "gyro"], per: float) -> Callable[[Excitation], list[Columns]]:
    """Return columns of a bias of its own for each soak and sensor, ``per`` [g], [deg/s] of a unit."""

    def columns(excitation: Excitation) -> list[Columns]:
        names, own = _own(excitation)
        way = Columns(names)
        return [replace(way, accel=own) if acts_on == "accel" else replace(way, gyro=per * own)] if names else []

    return columns


def _own(excitation: Excitation) -> tuple[tuple[str, ...], FloatArray]:
    """Return the coefficients' names, and 1 at a soak's nodes in each of its columns (n, 3, k)."""
    of_step = [(step.campaign, soak_of(step)) if step.kind == "soak" else None for step in excitation.steps]
    soaks = [soak for soak in dict.fromkeys(of_step) if soak is not None]
    if len(soaks) < 2:
        return (), np.zeros((len(excitation.t), 3, 0))
    own = np.zeros((len(excitation.t), 3, 3 * len(soaks)))
    for i, soak in enumerate(soaks):
        here = np.array([each == soak for each in of_step])[excitation.step]
        own[here, :, 3 * i : 3 * i + 3] = np.eye(3)
    return tuple(f"{soak[0] + 1}.{soak[1]}.{axis}" for soak in soaks for axis in AXES), own


ACCELEROMETER_TURN_ON = Effect(
    name="accelerometer.turn_on_bias",
    meaning="Turn-on bias, another one in each recording at rest",
    about=(
        "Turn-on to turn-on repeatability. A column for every soak and sensor. It shows in the means of soaks "
        "that determine no calibration (`procedures.evidence.thermal_soaks`), of which two or more lie side by "
        "side. Plausible: 30 deg/h and 1 mg, of which ten times as much is believed."
    ),
    unit="g",
    physics="the bias of every recording is random, standard deviation = value",
    source="IEEE Std 1293, bias repeatability",
    plausible=1e-3,
    columns=_turn_on("accel", 1.0),
    separate_by="the same recordings once more, some of them without switching off in between, at one temperature",
    is_scatter=True,
)
GYROSCOPE_TURN_ON = replace(
    ACCELEROMETER_TURN_ON,
    name="gyroscope.turn_on_bias",
    unit="deg/h",
    source="IEEE Std 952, bias repeatability",
    plausible=30.0,
    columns=_turn_on("gyro", 1 / DEG_H_PER_DEG_S),
)


def tilt_columns(excitation: Excitation) -> Jumps:
    """Return a rotation (x, y, z) of all that is seen, at every place of a soak and between dwells [.. per rad].

    In a soak it is of the specific force alone: of the Earth's rate it leaves nothing to be seen.
    """
    if not np.isfinite(excitation.f).all():
        return Jumps([])
    turned = np.stack([np.cross(excitation.f, axis) for axis in np.eye(3)], axis=2)

    # outputs of accelerometers nobody calibrated are off gravity's direction: a tilt shows along them too
    is_raw = bool(np.array_equal(excitation.f, excitation.accel_output))
    length = np.linalg.norm(excitation.f, axis=1, keepdims=True)
    along = (excitation.f / length)[:, :, None] / UG_PER_G
    names = (*AXES, ALONG) if is_raw else AXES
    side_effects = {ALONG: UNCALIBRATED * UG_PER_G} if is_raw else {}

    def tilted(where: dict[str, object], later: FloatArray) -> Columns:
        acts = np.concatenate((turned, along), axis=2) if is_raw else turned
        return Columns(names, where=where, accel=later[:, None, None] * acts, side_effects=side_effects)

    def slipped(where: dict[str, object], later: FloatArray) -> Columns:
        rotation = later[:, None, None] * np.eye(3)
        accel, gyro = rotation_columns(excitation, rotation)
        return Columns(AXES, accel=accel, gyro=gyro, rotation=rotation, where=where, plausible=(SLIP,) * 3)

    blocks = block_times(excitation)
    between = [(step, place_after(excitation, step, blocks), later) for step, later in places(excitation)]
    found = [(where, later) for step, where, later in between if step.kind == "soak"]
    slips = [partial(slipped, where, later) for step, where, later in between if step.kind == "dwell"]
    found += [
        (place_within(excitation, s, seconds, blocks), later)
        for s, seconds, later in places_within(excitation)
        if s.kind == "soak"
    ]
    return Jumps([*(partial(tilted, where, later) for where, later in found), *slips])


UNIT_TILT = Effect(
    name="placement.tilt",
    meaning="The unit was tilted, or slipped in its fixture, and stays so",
    about=(
        "A nudge, a stand that gives way, a screw that is loose. All that is seen turns by a small rotation from "
        "some moment on. In one rest what is along gravity stays, and a jump of the accelerometers' biases across "
        "it looks the same; between the dwells of a campaign it goes with the attitude. Plausible: 0.01 rad, or "
        "as far as a rest drifts; between dwells 1e-4 rad, 0.01 mm on 100 mm."
    ),
    unit="rad",
    physics="rotation(x, y, z) of all that is seen, from a moment on",
    source="IEEE Std 1293, stability of the test pier",
    plausible=0.01,
    columns=tilt_columns,
    is_turn=True,
    next_measurement="again",
    separate_by="the rest again, with nobody near the stand; at another attitude a bias is along gravity",
    driver="time",
)
