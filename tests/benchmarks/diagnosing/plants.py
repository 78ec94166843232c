"""What is planted: each name of the catalogue, in a design that excites it, and how large a size is drawn."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drivers.simulated.bench_in_memory import SETTLING_S
from procedures.positions import cross_axes, face_of
from tests.benchmarks.diagnosing.sigmas import Sigmas

LEAST, MOST = 6.0, 12.0  # sigmas
JUMPS_S = (400.0, 1200.0)  # of device time, while the twelve positions are recorded
COUNT_RATE = 5000.0  # count/(g s), of every unit here, roughly
SWING = (1.5, 4.0)  # counts, by which a disturbance swings the running count: it has no column and no such sigma
CLOSURE_DEG, HEADING_DEG = (0.028, 0.059), (0.14, 0.30)  # next to 0.01 and 0.05 stated: 3 to 6 times that in all
XYZ = ("x", "y", "z")
MATRIX = tuple(a + b for a in XYZ for b in XYZ)
Sizes = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Plant:
    """An effect, the design it is planted in, and the coefficients that may be."""

    effect: str
    design: str
    keys: tuple[str, ...]
    sigma: float = 0.0  # given where the campaign shows none of its own
    between: tuple[float, float] | None = None  # sizes, where they are no multiples of a sigma
    label: str = ""

    @property
    def name(self) -> str:
        """Return the effect, and what is particular about it."""
        return f"{self.effect}, {self.label}" if self.label else self.effect


PLANTS = {plant.name: plant for plant in (
    Plant("accelerometer.quadratic", "certified", XYZ),
    Plant("accelerometer.quadratic", "free", XYZ, label="free"),
    Plant("accelerometer.cubic", "free", XYZ),
    Plant("accelerometer.scale_asymmetry", "free", XYZ),
    Plant("accelerometer.cross_product", "free", ("xy", "xz", "yx", "yz", "zx", "zy")),
    Plant("accelerometer.bias_temperature", "warm", XYZ),
    Plant("accelerometer.scale_temperature", "two temperatures", XYZ),
    Plant("accelerometer.bias_drift", "warm", XYZ),
    Plant("accelerometer.relaxation", "plain", XYZ),
    Plant("gyroscope.g_sensitivity", "plain", MATRIX),
    Plant("gyroscope.bias_temperature", "warm", XYZ),
    Plant("gyroscope.scale_temperature", "two temperatures", XYZ),
    Plant("gyroscope.temperature_rate", "warm", XYZ),
    Plant("gyroscope.bias_drift", "warm", XYZ),
    Plant("gyroscope.magnetic", "plain", MATRIX),
    Plant("gyroscope.scale_asymmetry", "two speeds", XYZ),
    Plant("gyroscope.scale_nonlinearity", "two speeds", XYZ),
    Plant("gyroscope.sagnac_sine", "two speeds", XYZ),
    Plant("slab.tilt", "plain", ("east", "north")),
    # one face alone is not seen, only its pair against the certificate
    Plant("fixture.face_tilt", "certified", ("x_up.y", "y_down.z", "z_up.x"), sigma=1e-5),
    Plant("fixture.parallelism", "plain", ("x.y", "y.z", "z.x")),
    Plant("placement.dwell", "plain", XYZ),
    Plant("placement.label", "plain", ("actual",)),
    Plant("site.azimuth", "plain", ("value",)),
    Plant("site.latitude", "plain", ("value",)),
    Plant("accelerometer.jump", "plain", XYZ, sigma=1e-6),
    Plant("gyroscope.jump", "plain", XYZ, sigma=0.025),
    # likelier at a bench than an effect of the instrument, and named before it
    Plant("site.latitude", "repeated", ("value",), between=(0.0052, 0.0087), label="0.3 to 0.5 deg"),
    Plant("procedure.closure", "repeated", ("value",), between=CLOSURE_DEG, label="3 to 6 times"),
    Plant("procedure.heading", "repeated", ("value",), between=HEADING_DEG, label="3 to 6 times"),
    Plant("placement.scatter", "repeated", ("value",), between=(1e-5, 5e-5), label="2 to 10 arcsec"),
    # where a campaign shows enough of them: turns three times over, dwells ten times as long
    Plant("procedure.closure", "turned thrice", ("value",), between=CLOSURE_DEG, label="turned thrice"),
    Plant("procedure.heading", "long dwells", ("value",), between=HEADING_DEG, label="long dwells"),
    Plant("placement.scatter", "plain", ("value",), between=(1e-5, 5e-5)),
    Plant("site.gravity", "two sites", ("value",)),
    Plant("clock.rate", "timed", ("value",)),
    Plant("disturbance.dwell", "plain", XYZ),
    Plant("auxiliary.channel", "auxiliary", ("ax", "ay", "az", "gx", "gy", "gz")),
    Plant("gyroscope.g_sensitivity", "moved", MATRIX, label="moved"),
    Plant("gyroscope.scale_asymmetry", "moved", XYZ, label="moved"),
    Plant("gyroscope.scale_asymmetry", "moved and turned", XYZ, label="moved and turned"),
    Plant("gyroscope.bias_temperature", "moved while warm", XYZ, label="moved"),
)}  # fmt: skip


def drawn_sizes(name: str, sigmas: Sigmas, rng: np.random.Generator) -> dict[str, float]:
    """Draw what the simulator is to plant: one coefficient or several, of `LEAST` to `MOST` sigmas each."""
    plant = PLANTS[name]
    if plant.effect == "placement.label":
        return _label(rng)
    if plant.effect == "disturbance.dwell":
        return _disturbance(rng)
    if plant.between is not None:
        return {"value": float(rng.uniform(*plant.between))}
    keys, position = list(plant.keys), 0
    several = rng.random() < 0.5
    chosen = rng.choice(keys, rng.integers(1, len(keys) + 1), replace=False) if several else [rng.choice(keys)]
    if plant.effect == "placement.dwell":  # accelerometers see nothing of the heading, along the vertical
        position = int(rng.integers(1, 13))
        chosen = ["xyz"[i] for i in cross_axes(face_of(position))]
    tau = float(np.exp(rng.uniform(np.log(5), np.log(45))))
    sizes = {str(k): _drawn(rng) * sigmas.of(str(k), position, tau) for k in chosen}
    if plant.effect == "gyroscope.sagnac_sine":  # fitted is its square, and a sine has no sign
        sizes = {k: float(np.sqrt(rng.uniform(LEAST, MOST) * sigmas.of(k))) for k in sizes}
    if plant.effect.endswith(".jump"):  # at any time, the most within a dwell
        sizes["after_s"] = float(rng.uniform(*JUMPS_S))
    if plant.effect == "accelerometer.relaxation":  # the cube has rested for a while before the step begins
        return {k: size * float(np.exp(SETTLING_S / tau)) for k, size in sizes.items()} | {"tau_s": tau}
    return sizes | ({"position": float(position)} if position else {})


def _drawn(rng: np.random.Generator) -> float:
    return float(rng.choice([-1, 1]) * rng.uniform(LEAST, MOST))


def _label(rng: np.random.Generator) -> dict[str, float]:
    position, actual = rng.choice(np.arange(1, 13), 2, replace=False)
    return {"position": float(position), "actual": float(actual)}


def _disturbance(rng: np.random.Generator) -> dict[str, float]:
    hertz = rng.uniform(0.5, 3.0)
    size = rng.uniform(*SWING) * 2 * np.pi * hertz / COUNT_RATE
    along = {axis: float(size * rng.uniform(0.3, 1.0)) for axis in XYZ}
    along[str(rng.choice(XYZ))] = float(size)
    return along | {
        "position": float(rng.integers(1, 13)), "at_s": float(rng.uniform(15, 70)),
        "duration_s": float(rng.uniform(5, 20)), "hz": float(hertz),
    }  # fmt: skip
