"""Whole logs as loggers write them, with the true kind, axis and unit of each column.

Written without the code under test: names, units and full scales are those of public logs and data sheets. The
rates turn gravity as a body that rotates about one axis does, so that both triads tell of the same motion.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from station.files.tables.table import Table
from tests.station.files.logs.generated_times import Stamps, generated

G = 9.80665  # m/s2
AXES = "xyz"
SENSORS = ("gyro", "accel")
KINDS = ("soak", "rests", "motion")
COPIES = 0.03  # of triads in a unit have their counts next to them
MAX_RATE = 300.0  # deg/s, within the range of every full scale below

_GYRO_NAMES = (
    "g{a}", "G{a}", "gyro_{a}", "w{a}", "W{A}", "AngVel{A}", "Gyro{A}", "gyr_{a}", "w_{a}", "gyro.{a}",
    "omega_{a}",
    "rate_{a}", "angular_velocity_{a}", "Gyr{A}", "Gyroscope {a}", "gyro{A}", "{a}_gyro", "angular_rate_{a}",
    "GYRO_{A}", "imu.gyro.{a}", "ang_vel_{a}", "g_{a}", "Rate {A}", "gyro_data_{a}",
)  # fmt: skip
_ACCEL_NAMES = (
    "a{a}", "acc{A}", "accel_{a}", "a_{a}", "Acc{A}", "Accel{A}", "acceleration_{a}", "linear_acceleration_{a}",
    "A{a}", "f{a}", "f_{a}", "accelerometer_{a}", "specific_force_{a}", "acc_{a}", "Acceleration {A}", "{a}_acc",
    "ACC_{A}", "imu.accel.{a}", "acc.{a}", "gF{a}", "accel_data_{a}", "Accelerometer {a}",
)  # fmt: skip
NAMES = {"gyro": _GYRO_NAMES, "accel": _ACCEL_NAMES}
LETTER_OF_THE_OTHER = {"gyro": ("a{a}", "A{a}"), "accel": ("g{a}", "G{a}")}  # as in "Gx (g)"
MAG_NAMES = (
    "m{a}", "mag{A}", "mag_{a}", "Mag_{a} [uT]", "mag_{a}_uT", "compass_{a}", "b{a} [nT]", "Mag{A} [G]",
    "magnetic_field_{a}", "H{a} (mG)", "magnetometer_{a}",
)  # fmt: skip
OTHER_COLUMNS = (
    "temp_c",
    "Temperature",
    "pressure",
    "roll",
    "pitch [deg]",
    "seq",
    "counter",
    "status",
    "q0",
    "altitude",
)

UNITS = {  # outputs in 1 deg/s or 1 g
    "gyro": {"deg/s": 1.0, "mdps": 1e3, "rad/s": np.pi / 180, "deg/h": 3600.0},
    "accel": {"g": 1.0, "mg": 1e3, "m/s2": G, "cm/s2": 100 * G},
}
LSB = {
    "gyro": (131.0, 65.5, 32.8, 16.4, 114.285714, 57.142857),
    "accel": (16384.0, 8192.0, 4096.0, 2048.0, 1024.0, 256.0),
}
BRACKETED = {
    "deg/s": ("deg/s", "dps", "°/s", "deg/sec"), "mdps": ("mdps", "mdeg/s"), "rad/s": ("rad/s", "rad/sec"),
    "deg/h": ("deg/h", "°/h", "deg/hr"), "g": ("g",), "mg": ("mg",), "m/s2": ("m/s2", "m/s^2", "m/s²"),
    "cm/s2": ("cm/s2", "Gal"), "LSB": ("LSB", "raw", "counts"),
}  # fmt: skip
BEHIND = {
    "deg/s": ("dps", "deg_s"), "mdps": ("mdps",), "rad/s": ("rad_s", "rads"), "deg/h": ("deg_h", "dph"),
    "g": ("g",), "mg": ("mg",), "m/s2": ("m_s2", "mps2", "ms2"), "cm/s2": ("cm_s2",), "LSB": ("lsb", "raw", "adc"),
}  # fmt: skip
SPELLINGS = {
    unit: [*(f"[{u}]" for u in BRACKETED[unit]), *(f"({u})" for u in BRACKETED[unit]),
           *(f"_{u}" for u in BEHIND[unit])] for unit in BRACKETED
}  # fmt: skip
DECIMALS = {"deg/s": 4, "mdps": 1, "rad/s": 6, "deg/h": 2, "g": 5, "mg": 2, "m/s2": 4, "cm/s2": 2, "LSB": 0}


@dataclass(frozen=True, slots=True, eq=False)
class Triad:
    """Names of x, y, z, the unit, and how many outputs are 1 deg/s or 1 g."""

    names: tuple[str, ...]
    unit: str
    per_unit: float


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """What a column is in truth: ``gyro`` or ``accel``, its axis, and outputs in 1 deg/s or 1 g.

    ``is_stated``: the name holds a unit, and not one of counts.
    """

    sensor: str
    axis: str
    per_unit: float
    is_stated: bool


@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """A log's columns in the order of the file, and what its ``channels`` are in truth, by their names."""

    file: str
    time: Stamps
    columns: Mapping[str, FloatArray]
    decimals: Mapping[str, int]
    channels: Mapping[str, Channel]
    kind: str

    @property
    def table(self) -> Table:
        """The log as a reader returns it."""
        moments = frozenset({self.time.name}) if self.time.unit == "iso8601" else frozenset[str]()
        return Table(Path(self.file), self.columns, "", moments=moments, time_scale_s=self.time.scale_s)

    def write(self, folder: Path) -> Path:
        """Write it as text; of a scale in the header, the line above the table as a .gcsv has it."""
        time = [f"{each:.{self.time.decimals}f}" for each in self.time.stamps]
        if self.time.unit == "iso8601":
            time = [f"{each}Z" for each in (self.time.stamps * 1e6).round().astype("datetime64[us]")]
        others = {name: values for name, values in self.columns.items() if name != self.time.name}
        cells = [[f"{v:.{self.decimals[name]}f}" for v in values] for name, values in others.items()]
        above = [] if self.time.scale_s is None else [f"tscale,{self.time.scale_s!r}"]
        rows = (",".join(row) for row in zip(time, *cells, strict=True))
        (folder / self.file).write_text("\n".join([*above, ",".join(self.columns), *rows]) + "\n")
        return folder / self.file


def generated_log(rng: np.random.Generator, file: str = "log.csv") -> Log:
    """Return a log of one or two triads, with what else loggers write next to them."""
    time, kind = generated(rng), str(rng.choice(KINDS))
    truth = dict(zip(SENSORS, _motion(kind, time.t - time.t[0], rng), strict=True))
    has = {"both": SENSORS, "gyro": ("gyro",), "accel": ("accel",)}[
        str(rng.choice(["both", "both", "gyro", "accel"]))
    ]
    triads = [(sensor, triad) for sensor in has for triad in _triads(sensor, len(has) == 2, rng)]
    columns, decimals, channels = dict[str, FloatArray](), dict[str, int](), dict[str, Channel]()
    for sensor, triad in triads if rng.random() < 0.5 else triads[::-1]:
        for i, name in enumerate(triad.names):
            decimals[name] = DECIMALS[triad.unit]
            columns[name] = np.round(triad.per_unit * truth[sensor][:, i], decimals[name])
            is_stated = triad.unit != "LSB" and name.endswith(tuple(SPELLINGS[triad.unit]))
            channels[name] = Channel(sensor, AXES[i], triad.per_unit, is_stated)
    more = _other_columns(len(time.t), rng)
    decimals |= dict.fromkeys(more, 3)
    is_last = rng.random() < 0.7
    columns = {time.name: time.stamps, **(columns | more if is_last else more | columns)}
    return Log(file, time, columns, decimals, channels, kind)


def _triads(sensor: str, has_other: bool, rng: np.random.Generator) -> list[Triad]:
    """Return a triad, and of some that state their unit another one: the same sensor's counts."""
    name, triad = _triad(sensor, has_other, rng)
    bare = tuple(name.format(a=a, A=a.upper()) for a in AXES)
    if triad.unit == "LSB" or triad.names == bare or rng.random() > COPIES:
        return [triad]
    counts = float(rng.choice(LSB[sensor]))
    ending = str(rng.choice(["", "_raw"]))
    return [triad, Triad(tuple(each + ending for each in bare), "LSB", counts)]


def _triad(sensor: str, has_other: bool, rng: np.random.Generator) -> tuple[str, Triad]:
    unit = str(rng.choice([*UNITS[sensor], "LSB"]))
    per_unit = UNITS[sensor].get(unit) or float(rng.choice(LSB[sensor]))
    form = str(rng.choice(["", "", "{} [{}]", "{} ({})", "{}({})", "{}_{}"]))
    names = list(NAMES[sensor])
    is_decided = form != "" and unit != "LSB"
    if is_decided or (sensor == "accel" and not has_other):  # else nobody could say which sensor it is
        names += (3 if is_decided else 1) * LETTER_OF_THE_OTHER[sensor]
    name = str(rng.choice(names))
    spelled = str(rng.choice((BEHIND if form == "{}_{}" else BRACKETED)[unit]))
    bare = [name.format(a=a, A=a.upper()) for a in AXES]
    return name, Triad(tuple(form.format(each, spelled) if form else each for each in bare), unit, per_unit)


def _motion(kind: str, t: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return rates [deg/s] and specific force [g] of a body that rotates by ``angle`` about one axis."""
    axis, up = _direction(rng), _direction(rng)
    share, seconds = t / t[-1], float(t[-1])
    angle, speed, shake = np.zeros(len(t)), np.zeros(len(t)), np.zeros((len(t), 3))
    if kind == "rests":  # six, with a rotation of 90 deg, or what the time allows, between them
        between = 0.3 * seconds / 5
        size = min(90.0, MAX_RATE * between / 2)
        for k in range(5):
            x = ((share * seconds - (k + 1) * 0.7 * seconds / 6 - k * between) / between).clip(0, 1)
            angle += size * (x - np.sin(2 * np.pi * x) / (2 * np.pi))
            speed += size / between * (1 - np.cos(2 * np.pi * x)) * ((x > 0) & (x < 1))
    if kind == "motion":
        swing, hz = rng.uniform(20, 90), rng.uniform(0.1, 1.0)
        swing = min(swing, MAX_RATE / (2 * np.pi * hz))
        angle = swing * np.sin(2 * np.pi * hz * t)
        speed = swing * 2 * np.pi * hz * np.cos(2 * np.pi * hz * t)
        shake = rng.uniform(0.02, 0.3) * np.sin(2 * np.pi * rng.uniform(1, 3) * t)[:, None] * _direction(rng)
    theta = np.radians(angle)[:, None]  # Rodrigues, of a vector that stands still seen from the body
    force = np.cos(theta) * up - np.sin(theta) * np.cross(axis, up) + (1 - np.cos(theta)) * (axis @ up) * axis
    rate = speed[:, None] * axis + rng.normal(0, 0.5, 3) + 0.05 * rng.standard_normal((len(t), 3))
    return rate, force + shake + rng.normal(0, 0.01, 3) + 2e-3 * rng.standard_normal((len(t), 3))


def _direction(rng: np.random.Generator) -> FloatArray:
    vector = rng.standard_normal(3)
    unit: FloatArray = vector / np.linalg.norm(vector)
    return unit


def _other_columns(rows: int, rng: np.random.Generator) -> dict[str, FloatArray]:
    found = dict[str, FloatArray]()
    if rng.random() < 0.35:
        name = str(rng.choice(MAG_NAMES))
        for a in AXES:
            found[name.format(a=a, A=a.upper())] = np.round(rng.uniform(-50, 50) + rng.standard_normal(rows), 3)
    for name in rng.choice(OTHER_COLUMNS, int(rng.choice([0, 0, 1, 2])), replace=False):
        found[str(name)] = np.round(25 + 0.1 * rng.standard_normal(rows), 3)
    return found
