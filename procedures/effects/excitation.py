"""What the sensors went through, and the columns by which an effect would show in what they put out."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.frames import rotation, skew

TAU = "tau_s"  # name of the coefficient that is a time constant [s]
PLAY = "play_k"  # name of the coefficient that is half the width of a play [K]
PERIOD = "period_s"  # name of the coefficient that is the period of a cycle [s]
KNEE = "knee_deg_s"  # name of the coefficient that is the rate from which on an effect acts [deg/s]
UNITS_OF_NONLINEAR = {TAU: "s", PLAY: "K", PERIOD: "s", KNEE: "deg/s"}
ALONG = "along_gravity_ug"  # name of the coefficient that is what a tilt leaves along gravity [ug]
UNITS_OF_COEFFICIENTS = UNITS_OF_NONLINEAR | {ALONG: "ug"}  # of those that are not in their effect's unit
REFERENCE_C = 25.0  # degC: temperature effects vanish there, and bias and scale factor hold there


@dataclass(frozen=True, slots=True, eq=False)
class Excitation:
    """What the sensors went through, at n nodes of all steps, in nominal attitude; IMU axes.

    ``f`` [g], ``omega`` [deg/s, Earth rate included], ``magnetic`` [uT] are (n, 3); ``accel_output`` [g] and
    ``gyro_output`` [deg/s], (n, 3), are what the triads put out, E u + D. ``change`` (n, 3) [g] is by how much f
    differs from the rest before. ``t`` [s] is device time, ``rest_s`` [s] the time since the step began,
    ``temperature`` [degC], ``temperature_rate`` [K/min], ``auxiliary`` channels: (n,). What is not known is nan.
    ``step`` (n,) numbers the steps of `steps`; ``C_sb`` (n, 3, 3) takes the cube's axes to the IMU's; ``E_accel``,
    ``E_gyro`` (n, 3, 3) are the triads' misalignments as they stand, unit where not solved. ``C_sn`` (n, 3, 3)
    takes East-North-Up to the IMU's axes, nan where the attitude is not known; None where none is.
    ``vibration`` (n, 3) [g^2] is the variance of the accelerometers' samples in a dwell or rest, 0 in other
    steps; None where it is not known.
    """

    f: FloatArray
    omega: FloatArray
    magnetic: FloatArray
    accel_output: FloatArray
    gyro_output: FloatArray
    change: FloatArray
    t: FloatArray
    rest_s: FloatArray
    temperature: FloatArray
    temperature_rate: FloatArray
    auxiliary: Mapping[str, FloatArray]
    step: IntArray
    C_sb: FloatArray
    E_accel: FloatArray
    E_gyro: FloatArray
    steps: tuple["ExcitationStep", ...]
    C_sn: FloatArray | None = None
    vibration: FloatArray | None = None

    @property
    def f_before(self) -> FloatArray:
        """Specific force (n, 3) [g] of the step before; of a first step nothing is known: its own."""
        return self.f - np.nan_to_num(self.change)

    @property
    def histories(self) -> IntArray:
        """Number (m,) of the history in time that each step is of: its campaign's, or that of a clock in it."""
        clocks = [(step.campaign, step.clock) for step in self.steps]
        numbers = {each: i for i, each in enumerate(sorted(set(clocks)))}
        return np.array([numbers[each] for each in clocks], dtype=np.int64)

    def per_step(self, name: str) -> FloatArray:
        """Return an attribute of the steps at every node (n,), as numbers."""
        values = np.array([float(getattr(step, name)) for step in self.steps])
        return values[self.step]


@dataclass(frozen=True, slots=True)
class ExcitationStep:
    """A step: name, kind (dwell, turn, move, rest, soak, rate), campaign, position (0: in none), face ('': none).

    ``stated_std`` [rad] is the 1 sigma stated of a dwell's heading, of a turn's closure; 0 where nothing is.
    ``slab_tilt`` [rad] is how a dwell's slab is tilted, as the model stands: up seen from it is (east, north, 1).
    ``tilt`` [rad] is the rotation vector, IMU axes, that turns what a dwell sees in nominal attitude into what it
    sees as the model stands, by slab, face and heading.
    ``clock`` numbers the clocks of a campaign whose recordings have not one time in common.
    """

    name: str
    kind: str
    campaign: int
    position: int
    face: str
    stated_std: float = 0.0
    slab_tilt: tuple[float, float] = (0.0, 0.0)
    clock: int = 0
    tilt: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """One way in which an effect may act.

    ``accel`` [g] and ``gyro`` [deg/s], (n, 3, k), are what a unit of each coefficient adds to E u + D at every
    node of `Excitation`, None where it adds nothing; ``rotation`` (n, 3, k) [rad] is by how much it turns all that
    is seen there: a move must carry the attitude before it into the one after. ``where`` says what of the
    campaign it is about, ``shape`` the value of what is not linear in it. A coefficient belongs to `coefficients`,
    in ``unit`` where this way has one of its own, else the effect's; ``plausible`` likewise, one a coefficient as
    it is fitted. ``nonlinear`` holds by name, above zero, what is fitted by its logarithm: the last of the
    coefficients. ``side_effects`` holds by name how large a coefficient plausibly is by the largest of the others,
    where it only goes with these.
    """

    coefficients: tuple[str, ...]
    accel: FloatArray | None = None
    gyro: FloatArray | None = None
    rotation: FloatArray | None = None
    where: Mapping[str, object] = field(default_factory=dict)
    shape: str = ""
    unit: str = ""
    plausible: tuple[float, ...] = ()
    nonlinear: Mapping[str, float] = field(default_factory=dict)
    orders: tuple[int, ...] = ()
    side_effects: Mapping[str, float] = field(default_factory=dict)

    @property
    def tau_s(self) -> float:
        """Its time constant [s], 0 where it has none."""
        return self.nonlinear.get(TAU, 0.0)


def without_gaps(excitation: Excitation, values: FloatArray) -> FloatArray:
    """Return a channel ``values`` (n,), in its unit, with what is missing within a step interpolated."""
    filled = values.copy()
    for number in range(len(excitation.steps)):
        nodes = np.flatnonzero(excitation.step == number)
        known = nodes[np.isfinite(values[nodes])]
        if len(known):
            filled[nodes] = np.interp(excitation.t[nodes], excitation.t[known], values[known])
    return filled


def per_axis(value: FloatArray) -> FloatArray:
    """Return columns (n, 3, 3) of a coefficient per sensor for a value (n,) or (n, 3), in its unit."""
    columns = np.zeros((len(value), 3, 3))
    columns[:, range(3), range(3)] = value[:, None] if value.ndim == 1 else value
    return columns


def rotation_columns(excitation: Excitation, rotation: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return accelerometer and gyroscope columns (n, 3, k) of small rotations of all that is seen.

    The rotation vectors ``rotation`` (n, 3, k) [rad] are in IMU axes and turn every vector as the IMU sees it;
    sensors see it by their misalignment, of which 3e-3 times a seating of 3e-4 rad are seven sigma of a dwell.
    """
    accel, gyro = np.zeros_like(rotation), np.zeros_like(rotation)
    at = np.flatnonzero(rotation.any(axis=(1, 2)))  # not in moves, whose nodes are the most
    accel[at] = -excitation.E_accel[at] @ skew(excitation.f[at]) @ rotation[at]
    gyro[at] = -excitation.E_gyro[at] @ skew(excitation.omega[at]) @ rotation[at]
    return accel, gyro


def turned_columns(excitation: Excitation, columns: Columns, c: FloatArray) -> tuple[Columns, Columns]:
    """Return what a turn of coefficients ``c`` (k,) adds, as one column and to every order, and its columns there.

    A seat of 4e-3 rad takes 8e-6 g from the sensor that is upright, five sigma of its bias, and as much from it on
    a slab that is tilted as far: what is turned is what the tilts of slab and face leave to be seen. At c a change
    of the rotation vector v by d turns what is seen by ``(1 + [v x] / 2) d`` more, to the first order in v.
    """
    assert columns.rotation is not None
    at = np.flatnonzero(columns.rotation.any(axis=(1, 2)))
    ways, tilts = columns.rotation[at], np.array([step.tilt for step in excitation.steps])
    vectors, tilted = ways @ c, rotation(tilts[excitation.step[at]])
    further = ways + skew(vectors) @ ways / 2
    added, slopes = list[FloatArray](), list[FloatArray]()
    for E, seen in ((excitation.E_accel, excitation.f), (excitation.E_gyro, excitation.omega)):
        before = (tilted @ seen[at][..., None])[..., 0]
        after = (rotation(vectors) @ before[..., None])[..., 0]
        total, slope = np.zeros((*seen.shape, 1)), np.zeros((*seen.shape, len(c)))
        total[at] = E[at] @ (after - before)[..., None]
        slope[at] = -E[at] @ skew(after) @ further
        added.append(total)
        slopes.append(slope)
    whole = np.zeros((len(columns.rotation), 3, 1))
    whole[at, :, 0] = vectors
    exact = Columns(("",), accel=added[0], gyro=added[1], rotation=whole)
    return exact, replace(columns, accel=slopes[0], gyro=slopes[1])


# Time constants and what else is not linear: the search begins at steps too small for a minimum to hide between.
# From the best one on they are fitted with the coefficients, by their logarithms (Golub and Pereyra 1973).
TAU_RATIO = 1.7  # between neighbours, at most
LONGEST_TAU = 3.0  # times what was recorded: beyond it an exponential is a straight line
LOG_RANGE = 3.0  # plausible change of a logarithm from where the search begins
STEP = 1e-3  # of a logarithm, over which a slope is taken


def search(shortest_s: float, recorded_s: float) -> tuple[float, ...]:
    """Return time constants [s] to begin with, from the shortest to several times what was recorded."""
    longest = LONGEST_TAU * recorded_s
    if not 0 < shortest_s < longest:
        return ()
    count = 1 + int(np.ceil(np.log(longest / shortest_s) / np.log(TAU_RATIO)))
    return tuple(np.geomspace(shortest_s, longest, count).tolist())


def with_nonlinear(way: Columns, plausible: tuple[float, ...]) -> Columns:
    """Return a way with what is not linear as its last coefficients, of which nothing is known yet: zero.

    ``plausible`` are 1 sigma of the others, each in its unit.
    """
    names, more = tuple(way.nonlinear), len(way.nonlinear)
    return replace(
        way, coefficients=(*way.coefficients, *names), plausible=(*plausible, *(LOG_RANGE,) * more),
        accel=_appended(way.accel, more), gyro=_appended(way.gyro, more),
    )  # fmt: skip


def _appended(part: FloatArray | None, more: int) -> FloatArray | None:
    return None if part is None else np.concatenate((part, np.zeros((*part.shape[:2], more))), axis=2)
