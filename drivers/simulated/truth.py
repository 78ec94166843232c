"""What is true of a simulated unit and its bench: the one thing every simulated count follows from.

Field names are the keys of the TOML file and carry their units. Triads follow ``N = k (E u + D)`` of
Yao, Hu, He 2018, eq. (1), (2): u in g and deg/s, IMU axes; E rows = sensor. Faces and slab as in
`procedures.frames`: faces by `procedures.positions.FACES`, slab tilt as East and North components of the up
vector seen from the slab. What a campaign *states* is the `Truth`, what the sensors *feel* is the `World`.
"""

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from drivers.errors import TruthRefused
from procedures.arrays import FloatArray
from procedures.frames import TRIADS, rotation, vertical_rotation
from procedures.geodesy import earth_rate_n, normal_gravity
from procedures.positions import FACES, C_bn, face_normal, face_of
from procedures.units import DEG_H_PER_DEG_S, STANDARD_GRAVITY

Sizes = Mapping[str, float]
IMU_AXES = ("+x", "+y", "+z")
P1_THETA = 0.04 / 400  # rad; every fixture item 0.04 mm on a 400 mm cube (Yao, Hu, He 2018, section 4)

_SHAPES: dict[str, tuple[int, ...]] = {
    "accel_k": (3,), "accel_e": (3, 3), "accel_d_g": (3,),
    "gyro_k": (3,), "gyro_e": (3, 3), "gyro_d_deg_s": (3,),
    "faces_rad": (6, 2), "slab_tilt_rad": (2,), "magnetic_enu_ut": (3,),
}  # fmt: skip


PERIODS_S = (1e-5, 4.0)  # s: 100 kHz; the counts format states it in ns, as a word of 32 bits
LARGEST = 1e12  # of any number of a truth
TURN_ON = "turn_on_bias"  # of planted effects, by triad: drawn with the power-on


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Truth:
    """A unit, its cube, slab, site and operator. All noise sigmas may be zero."""

    serial: str = "SIM-0"
    model: str = "SIM-FOG3"
    sample_period_s: float = 0.02
    latitude_deg: float = 31.17
    longitude_deg: float = 121.4
    height_m: float = 0.0  # above the ellipsoid; a simulated GNSS receiver stands there too
    gravity_m_s2: float | None = None  # felt at rest; None: normal gravity of latitude and height
    magnetic_enu_ut: FloatArray = field(default_factory=lambda: np.array([-3.0, 34.0, -36.0]))

    accel_k: FloatArray = field(default_factory=lambda: np.full(3, 1000.0))  # scale factors [count/(g s)]
    accel_e: FloatArray = field(default_factory=lambda: np.eye(3))
    accel_d_g: FloatArray = field(default_factory=lambda: np.zeros(3))  # biases at 25 degC [g]
    gyro_k: FloatArray = field(default_factory=lambda: np.full(3, 36000.0))  # scale factors [count/deg]
    gyro_e: FloatArray = field(default_factory=lambda: np.eye(3))
    gyro_d_deg_s: FloatArray = field(default_factory=lambda: np.zeros(3))  # biases at 25 degC [deg/s]

    accel_noise_g: float = 1e-5  # white noise of a sample, 1 sigma; velocity random walk is it times sqrt(period)
    gyro_arw_deg_rt_s: float = 1e-4  # angle random walk [deg/sqrt(s)]
    accel_instability_g: float = 0.0  # bias instability: stationary 1 sigma of a first-order Gauss-Markov process
    gyro_instability_dph: float = 0.01  # bias instability, stationary 1 sigma; first-order Gauss-Markov too
    instability_tau_s: float = 200.0  # correlation time of both; the Allan deviation peaks near 1.9 of it
    accel_turn_on_g: float = 0.0  # turn-on repeatability of the bias, 1 sigma [g], one draw per power-on
    gyro_turn_on_dph: float = 0.0  # turn-on repeatability of the bias, 1 sigma [deg/h], one draw per power-on

    temperature_start_c: float = 23.0
    temperature_rise_k: float = 0.0
    temperature_tau_s: float = 1800.0
    temperature_swing_k: float = 0.0  # amplitude of a sine on top of ``start + rise (1 - exp(-t / tau))``
    temperature_swing_period_s: float = 3600.0

    faces_rad: FloatArray = field(default_factory=lambda: np.zeros((6, 2)))
    slab_tilt_rad: FloatArray = field(default_factory=lambda: np.zeros(2))
    slab_azimuth_rad: float = 0.0  # how far the slab's North mark points east of true north
    heading_std_deg: float = 0.05  # operator's scatter of a position's heading, 1 sigma, one draw per placement
    closure_std_deg: float = 0.01  # how well a turn comes back to where it began, 1 sigma, one draw per turn
    settle_rad: float = 2e-5  # tilt amplitude right after a flip, ``A exp(-t / tau) sin(2 pi f t)``
    settle_tau_s: float = 0.3
    settle_hz: float = 4.0
    imu_axes: tuple[str, str, str] = IMU_AXES  # cube axes along which IMU x, y, z point
    effects: Mapping[str, Sizes] = field(default_factory=dict)  # by name, see `drivers.simulated.effects`
    terms: Mapping[str, str] = field(default_factory=dict)  # texts of effect/1 by name, of those in no catalogue

    def __post_init__(self) -> None:
        for name, shape in _SHAPES.items():
            got = getattr(self, name).shape
            if got != shape:
                raise TruthRefused(f"{name} has shape {got}", f"shape {shape}")
        low, high = PERIODS_S
        if not low <= self.sample_period_s <= high:
            raise TruthRefused(f"sample_period_s = {self.sample_period_s}", f"{low:g} to {high:g}")
        if not _is_right_handed(self.imu_axes):
            raise TruthRefused(f"imu_axes = {self.imu_axes}", 'right-handed cube axes, such as ["-y", "+x", "+z"]')

    @classmethod
    def example(cls, seed: int) -> "Truth":
        """Return a random unit of the size real ones have: misalignment 1e-3, faces and slab 3e-5 rad."""
        rng = np.random.default_rng([seed, 0x7EA1])
        return cls(
            serial=f"SIM-{seed}",
            accel_k=1000 + 30 * rng.standard_normal(3),
            accel_e=_misaligned(rng, 2e-3),
            accel_d_g=2e-3 * rng.standard_normal(3),
            gyro_k=36000 + 500 * rng.standard_normal(3),
            gyro_e=_misaligned(rng, 7e-4),
            gyro_d_deg_s=2e-4 * rng.standard_normal(3),
            faces_rad=3e-5 * rng.standard_normal((6, 2)),
            slab_tilt_rad=3e-5 * rng.standard_normal(2),
        )

    @property
    def local_gravity(self) -> float:
        """Gravity [m/s2] at the site: as given, else normal gravity of its latitude and height."""
        if self.gravity_m_s2 is not None:
            return self.gravity_m_s2
        return normal_gravity(float(np.radians(self.latitude_deg)), self.height_m)

    def powered_on(self, rng: np.random.Generator) -> "Truth":
        """Return the truth of one power-on: turn-on biases drawn into D, their sigmas zero."""
        accel, gyro = rng.standard_normal((2, 3))
        planted = [self.effects.get(f"{triad}.{TURN_ON}", {}).get("value", 0.0) for triad in TRIADS]
        accel_std = float(np.hypot(self.accel_turn_on_g, planted[0]))
        gyro_std = float(np.hypot(self.gyro_turn_on_dph, planted[1]))
        return replace(
            self,
            accel_d_g=self.accel_d_g + accel_std * accel,
            gyro_d_deg_s=self.gyro_d_deg_s + gyro_std / DEG_H_PER_DEG_S * gyro,
            accel_turn_on_g=0.0,
            gyro_turn_on_dph=0.0,
            effects={name: sizes for name, sizes in self.effects.items() if not name.endswith(f".{TURN_ON}")},
        )


def _is_right_handed(axes: tuple[str, ...]) -> bool:
    rows = [[(axis == f"+{name}") - (axis == f"-{name}") for name in "xyz"] for axis in axes]
    return len(rows) == 3 and bool(np.linalg.det(np.array(rows, dtype=np.float64)) > 0.5)


def _misaligned(rng: np.random.Generator, size: float) -> FloatArray:
    off = size * rng.standard_normal((3, 3))
    np.fill_diagonal(off, 0.0)
    np.fill_diagonal(off, np.sqrt(1 - np.sum(off**2, axis=1)))
    return off


def paper_truth() -> Truth:
    """Return the unit and cube of Yao, Hu, He 2018, tables 3 to 6: every fixture item `P1_THETA`.

    The paper gives accelerometers only; the gyros are ideal at 36000 count/deg.
    """
    return Truth(
        serial="P1",
        gravity_m_s2=STANDARD_GRAVITY,
        accel_k=np.array([1020.0, 1015.0, 1018.0]),
        accel_e=np.array([[0.999995, 0.001, 0.003], [0.002, 0.9999975, 0.001], [0.003, 0.002, 0.9999935]]),
        accel_d_g=np.array([0.001, 0.002, 0.001]),
        gyro_instability_dph=0.0,
        faces_rad=P1_THETA * np.array([[1, 0], [0, 3], [0, 3], [5, 0], [0, 3], [5, 0.0]]),
    )


def truth_from(table: Mapping[str, Any], base: Truth | None = None) -> Truth:
    """Return the truth a parsed TOML table describes; keys left out are those of ``base``, else the default.

    Raises `TruthRefused`: an unknown key, a wrong type or shape; says what is accepted.
    """
    accepted = {f.name: f for f in fields(Truth)}
    values: dict[str, Any] = {}
    for key, value in table.items():
        if key == "fault":
            continue  # ``drivers.simulated.faults`` reads it from the same file
        if key not in accepted:
            raise TruthRefused(f"key {key!r}", ", ".join(accepted))
        values[key] = _converted(key, value)
    return replace(base or Truth(), **values)


def load_truth(text: str) -> Truth:
    """Return the truth written as TOML text (key = value, effects as ``[effects."name"]`` tables)."""
    try:
        return truth_from(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise TruthRefused(str(error), "TOML") from error


def _converted(key: str, value: Any) -> Any:
    if key == "effects":
        return _effects(value)
    if key == "terms":
        if isinstance(value, Mapping) and all(isinstance(text, str) for text in value.values()):
            return dict(value)
        expected = 'the text of an effect/1 each, as "gyroscope.dead_zone" = """..."""'
        raise TruthRefused(f"terms = {value!r}"[:80], expected)
    if key == "imu_axes":
        return tuple(str(axis) for axis in value)
    if key in {"serial", "model"}:
        if isinstance(value, str):
            return value
        raise TruthRefused(f"{key} = {value!r}", "text")
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise TruthRefused(f"{key} = {value!r}", "numbers") from error
    if isinstance(value, (bool, str)) or not np.all(np.isfinite(array)) or array.shape != _SHAPES.get(key, ()):
        raise TruthRefused(f"{key} = {value!r}"[:80], f"finite numbers of shape {_SHAPES.get(key, ())}")
    if (abs(array) > LARGEST).any():
        raise TruthRefused(f"{key} = {value!r}"[:80], f"at most {LARGEST:g}")
    return array if key in _SHAPES else float(array)


def _effects(value: Any) -> dict[str, Sizes]:
    found: dict[str, Sizes] = {}
    if not isinstance(value, Mapping):
        raise TruthRefused(f"effects = {value!r}", '[effects."accelerometer.quadratic"] with x = 4e-5')
    for name, sizes in value.items():
        # an unquoted name nests: effects.accelerometer.quadratic
        nested = isinstance(sizes, Mapping) and any(isinstance(size, Mapping) for size in sizes.values())
        if nested and "." not in name:
            found |= _effects({f"{name}.{rest}": size for rest, size in sizes.items()})
        elif isinstance(sizes, Mapping):
            found[name] = dict(_sizes(name, sizes))
        else:
            raise TruthRefused(f"effects.{name} = {sizes!r}", "a table of sizes, such as {x = 4e-5}")
    return found


def _sizes(name: str, table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, float]]:
    for key, size in table.items():
        if isinstance(size, Mapping) and size:
            yield from _sizes(name, size, f"{above}{key}.")
        elif isinstance(size, bool) or not isinstance(size, (int, float)) or not np.isfinite(size):
            raise TruthRefused(f"effects.{name}.{above}{key} = {size!r}", "a finite number")
        else:
            yield f"{above}{key}", float(size)


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """Site, slab, cube and seats; SI and radians.

    ``faces`` (6, 2) [rad] by `procedures.positions.FACES`; ``C_sb`` (3, 3) cube axes to IMU axes; ``seatings``
    rotation vectors (3,) [rad] in cube axes by position; ``labels`` the position where the cube truly is, by
    the one recorded; ``clock_ppm`` how fast the device's clock runs. ``heading_std``, ``closure_std`` and
    ``seat_std`` [rad] are 1 sigma by which headings, closures and seats scatter beyond what is stated.
    """

    latitude: float
    gravity: float
    magnetic_n: FloatArray
    faces: FloatArray
    slab_tilt: FloatArray
    azimuth: float
    C_sb: FloatArray
    seatings: Mapping[int, FloatArray] = field(default_factory=dict)
    labels: Mapping[int, int] = field(default_factory=dict)
    clock_ppm: float = 0.0
    heading_std: float = 0.0
    closure_std: float = 0.0
    seat_std: float = 0.0

    @property
    def f_n(self) -> FloatArray:
        """Specific force at rest (3,) [g], East-North-Up."""
        return np.array([0.0, 0.0, self.gravity / STANDARD_GRAVITY])

    @property
    def omega_ie_n(self) -> FloatArray:
        """Earth rate (3,) [deg/s], East-North-Up."""
        omega: FloatArray = np.degrees(earth_rate_n(self.latitude))
        return omega

    def attitude(self, position: int, heading: float = 0.0, seated: bool = True) -> FloatArray:
        """Return ``C_bn`` (3, 3), East-North-Up to the cube, when asked to rest in ``position`` 1..24.

        ``heading`` [rad] counter-clockwise from nominal. A planted seating error or wrong label acts only when
        ``seated``: a turn begins from a seat of its own.
        """
        actual = self.labels.get(position, position) if seated else position
        up_tilt = self.faces[FACES.index(face_of(actual))]
        C = C_bn(actual, self.slab_tilt, up_tilt, heading) @ vertical_rotation(self.azimuth)
        if seated and position in self.seatings:
            return rotation(self.seatings[position]) @ C
        return C

    def slab_normal_n(self) -> FloatArray:
        """Return the slab's normal (3,), East-North-Up: the axis of every hand turn."""
        from_east, from_north = self.slab_tilt
        # up seen from the slab is (e, n, ..): the normal seen from level tilts the other way
        C_nl = vertical_rotation(-self.azimuth) @ rotation(np.array([from_north, -from_east, 0.0]))
        normal_n: FloatArray = C_nl[:, 2]
        return normal_n


def imu_from_cube(imu_axes: tuple[str, str, str]) -> FloatArray:
    """Return the rotation ``C_sb`` (3, 3): its rows are the cube axes, such as ``-y``, of IMU x, y, z."""
    return np.array([face_normal(f"{name[1]}_{'up' if name[0] == '+' else 'down'}") for name in imu_axes])
