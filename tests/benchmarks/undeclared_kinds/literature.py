"""Fifteen kinds of error from the literature that nobody declares, with the answers that are right.

Their equations are plain numpy, apart from what is judged by them: no line of `procedures/effects` or of a
diagnosis is used. A size is what sensors of this class (FOG of 0.01 to 1 deg/h, quartz pendulum of 10 to 100 ug,
surface plate) have; it is drawn, and is no multiple of a sigma. Seven kinds have a name in the catalogue, eight
have none.

Sources: *1293*: IEEE Std 1293-1998, its model equation is clause 8.3 (K0, K1', K3, K_oq, K_po ...); *952*: IEEE
Std 952-1997, its model equation has D_T, D_dT/dt and the drift by a temperature gradient that changes with time;
*TW*: Titterton and Weston, Strapdown Inertial Navigation Technology; *Lefevre*: The Fiber-Optic Gyroscope.

``u`` is the input along a sensor, ``f`` [g] and ``omega`` [deg/s] are vectors in IMU axes, ``T`` [degC] is what
the thermometer shows, ``t`` [s] the time since power-on, ``s`` [s] since the cube was set down.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from drivers.simulated.effects import Planted, PlantedEffect, Stimulus, TriadInput
from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, level_axes, truth_of

DPH, UG, PPM, URAD = 1 / 3600.0, 1e-6, 1e-6, 1e-6  # deg/s of a deg/h, g, 1, rad
REFERENCE_C = 25.0
DAY_S = 86400.0
STEP_S = 0.5  # in which a temperature's history is followed
LONGEST_S = 12_000.0
Add = Callable[[Stimulus, TriadInput], np.ndarray]
Adds = Mapping[str, Add]  # by accel and gyro


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """What is drawn of one campaign's error: its size, and signs and shares ``along`` (3,) of the sensors."""

    rng: np.random.Generator
    truth: Truth
    size: float
    along: np.ndarray

    def number(self, low: float, high: float) -> float:
        """Draw between two numbers, evenly in the logarithm."""
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def direction(self) -> np.ndarray:
        """Draw a unit vector (3,)."""
        v = self.rng.standard_normal(3)
        return np.asarray(v / np.linalg.norm(v))

    def turned(self, r: Callable[[Stimulus], np.ndarray]) -> Adds:
        """Return what both triads feel when the unit is turned in its fixture by ``r`` (n or 1, 3) [rad]."""
        return {
            "accel": lambda seen, triad: -np.cross(r(seen), seen.f) @ self.truth.accel_e.T,
            "gyro": lambda seen, triad: -np.cross(r(seen), seen.omega) @ self.truth.gyro_e.T,
        }


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of error: ``made`` gives what is added to each triad, ``size`` bounds what is drawn [``unit``].

    ``truth`` are the names of the cause in the catalogue; of one that it lacks there are none, and nameless is
    right. ``same`` are names that may stand in for it, because they do the same to this campaign; ``reason`` says
    why these and no others.
    """

    name: str
    source: str
    design: str
    size: tuple[float, float]
    unit: str
    made: Callable[[Drawn], Adds]
    truth: tuple[str, ...]
    same: tuple[str, ...]
    reason: str

    @property
    def acceptable(self) -> frozenset[str]:
        """Return every name that is no error."""
        return frozenset((*self.truth, *self.same))

    def planted(self, seed: int, truth: Truth, scale: float = 1.0) -> Planted:
        """Return it for the simulator, ``scale`` times the size that is drawn; 0 plants nothing."""
        rng = np.random.default_rng([seed, 53])
        along = rng.choice([-1.0, 1.0], 3) * rng.uniform(0.5, 1.0, 3)
        if rng.random() < 0.5:  # one sensor alone
            along *= np.arange(3) == rng.integers(3)
        size = float(np.exp(rng.uniform(*np.log(self.size))))
        adds = self.made(Drawn(rng, truth, size * scale, along))
        one = {triad: lambda seen, its, sizes, add=add: add(seen, its) for triad, add in adds.items()}
        return ((PlantedEffect(self.name, self.unit, (), accel=one.get("accel"), gyro=one.get("gyro")), {}),)

    def campaigns(self, seed: int, scale: float = 1.0) -> tuple[Campaign, ...]:
        """Return the campaigns of a unit that has it; another unit, plate, cube and order of steps by the seed."""
        truth = truth_of(self.design, seed)
        return campaigns_of(truth, self.design, seed, self.planted(seed, truth, scale)).campaigns


# temperature ---------------------------------------------------------------------------------------------------


def lagged(seen: Stimulus, tau: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a temperature (n, 1) [degC] that follows the thermometer's with a lag, and its rate [K/min]."""
    t = np.arange(0.0, min(LONGEST_S, float(seen.t[-1, 0])) + 2 * STEP_S, STEP_S)
    T, keep = seen.temperature_at(t), float(np.exp(-STEP_S / tau))
    own = np.empty(len(T))
    own[0] = T[0]
    for i in range(1, len(T)):
        own[i] = keep * own[i - 1] + (1 - keep) * (T[i] + T[i - 1]) / 2
    at = np.interp(seen.t, t, own)
    return at, 60 * (np.interp(seen.t, t, T) - at) / tau


def played(seen: Stimulus, width: float) -> np.ndarray:
    """Return by how many half widths [K] the temperature (n, 1) leads what it drags along: the play operator."""
    t = np.arange(0.0, min(LONGEST_S, float(seen.t[-1, 0])) + 2 * STEP_S, STEP_S)
    T = seen.temperature_at(t)
    left, at = np.empty(len(T)), float(T[0])
    for i, now in enumerate(T.tolist()):
        at = left[i] = min(max(at, now - width), now + width)
    return np.interp(seen.t, t, (T - left) / width)


def shupe_of_two(drawn: Drawn) -> Adds:
    """Coil and spool: b = c1 dT1/dt + c2 dT2/dt, each temperature with its own time constant."""
    quick, slow, share = drawn.number(30, 100), drawn.number(400, 1200), drawn.rng.uniform(-0.8, 0.8)

    def add(seen: Stimulus, triad: TriadInput) -> np.ndarray:
        return drawn.size * DPH * drawn.along * (lagged(seen, quick)[1] + share * lagged(seen, slow)[1])

    return {"gyro": add}


def wavelength(drawn: Drawn) -> Adds:
    """One source feeds three coils: its mean wavelength shifts by so many ppm/K, K = 4 pi R L / (lambda c)."""
    sign = drawn.rng.choice([-1.0, 1.0])
    return {
        "gyro": lambda seen, triad: (
            (1 / (1 + sign * drawn.size * PPM * (seen.temperature - REFERENCE_C)) - 1) * (triad.raw + triad.bias)
        )
    }


def magnet_lags(drawn: Drawn) -> Adds:
    """The magnet's induction follows a temperature of its own: 1e-6 c (Tm - 25) (u + D), tau 200 to 900 s."""
    tau = drawn.number(200, 900)
    return {
        "accel": lambda seen, triad: (
            drawn.size * PPM * drawn.along * (lagged(seen, tau)[0] - REFERENCE_C) * (triad.raw + triad.bias)
        )
    }


def scale_hysteresis(drawn: Drawn) -> Adds:
    """K1 on warming is not K1 on cooling: 1e-6 h d u, d by a play of 0.5 to 1.5 K (magnet and its glue)."""
    width = drawn.rng.uniform(0.5, 1.5)
    return {
        "accel": lambda seen, triad: (
            drawn.size * PPM * drawn.along * played(seen, width) * (triad.raw + triad.bias)
        )
    }


def asymmetry_warms(drawn: Drawn) -> Adds:
    """The two halves of a push-pull torquer have unlike coefficients: 1e-6 a (T - 25) abs(u) / 2."""
    return {
        "accel": lambda seen, triad: (
            0.5 * drawn.size * PPM * drawn.along * (seen.temperature - REFERENCE_C) * np.abs(triad.raw)
        )
    }


def fixture_twists(drawn: Drawn) -> Adds:
    """The bolts of the cube expand unevenly: the unit turns in it by c (T - 25) about an axis of the cube."""
    axis = drawn.size * URAD * drawn.direction()
    return drawn.turned(lambda seen: axis * (seen.temperature - REFERENCE_C))


def hand_heat(drawn: Drawn) -> Adds:
    """Hands warm the case while it is carried; b = c d/ds (exp(-s / 6 tau) - exp(-s / tau)), size at s = 0."""
    quick = drawn.number(20, 60)

    def add(seen: Stimulus, triad: TriadInput) -> np.ndarray:
        s = np.where(np.isfinite(seen.rest_s), seen.rest_s, 1e6)  # while it turns, no hand is on it
        shape = (np.exp(-s / quick) - np.exp(-s / (6 * quick)) / 6) / (1 - 1 / 6)
        return drawn.size * DPH * drawn.along * shape

    return {"gyro": add}


# input ---------------------------------------------------------------------------------------------------------


def cubic(drawn: Drawn) -> Adds:
    """The field of the torquer is weaker away from the middle: K3 u^3."""
    return {"accel": lambda seen, triad: drawn.size * UG * drawn.along * triad.raw**3}


def pendulum_product(drawn: Drawn) -> Adds:
    """Forces along pendulum and hinge bend it together: K_po f_p f_o, the two axes that are not the sensor's."""
    return {
        "accel": lambda seen, triad: (
            drawn.size * UG * drawn.along * np.roll(seen.f, -1, axis=1) * np.roll(seen.f, -2, axis=1)
        )
    }


def dead_time(drawn: Drawn) -> Adds:
    """A converter to frequency counts nothing while it resets: u / (1 + k td abs(u)) - u, td in ns."""
    td = drawn.size * 1e-9 * np.abs(drawn.along)

    def add(seen: Stimulus, triad: TriadInput) -> np.ndarray:
        u = triad.raw + triad.bias
        return np.asarray(u / (1 + drawn.truth.accel_k * td * np.abs(u)) - u)

    return {"accel": add}


# time ----------------------------------------------------------------------------------------------------------


def accelerometer_warms_up(drawn: Drawn) -> Adds:
    """The servo's electronics warm at switch-on, the case does not: b exp(-t / tau), tau 200 to 600 s."""
    tau = drawn.number(200, 600)
    return {"accel": lambda seen, triad: drawn.size * UG * drawn.along * np.exp(-seen.t / tau)}


def mode_hop(drawn: Drawn) -> Adds:
    """The source's spectrum hops once: all three scale factors step by the same ppm at t1."""
    sign, when = drawn.rng.choice([-1.0, 1.0]), drawn.rng.uniform(900, 2400)
    return {"gyro": lambda seen, triad: sign * drawn.size * PPM * (seen.t > when) * (triad.raw + triad.bias)}


def flicker(drawn: Drawn) -> Adds:
    """Noise of 1 / frequency of the voltage reference: equal Gauss-Markov processes, an octave of tau each."""
    t = np.arange(0.0, LONGEST_S, 5.0)
    taus = 10.0 * 2.0 ** np.arange(9)
    keep = np.exp(-5.0 / taus)
    now = drawn.rng.standard_normal(9)
    path = np.empty(len(t))
    for i, shock in enumerate(drawn.rng.standard_normal((len(t), 9)) * np.sqrt(1 - keep**2)):
        path[i] = now.sum() / 3
        now = keep * now + shock
    late = 2500.0 * np.arange(3)  # each sensor another stretch of it

    def add(seen: Stimulus, triad: TriadInput) -> np.ndarray:
        return drawn.size * UG * drawn.along * np.interp((seen.t + late) % LONGEST_S, t, path)

    return {"accel": add}


# bench ---------------------------------------------------------------------------------------------------------


def floor_tilts(drawn: Drawn) -> Adds:
    """The floor leans with the sun: up moves by A (sin(2 pi (t / day + p)) - sin(2 pi p)) towards one azimuth.

    Gyroscopes see 15 deg/h times some 1e-5 of it, which is nothing.
    """
    azimuth, phase = drawn.rng.uniform(0, 2 * np.pi), drawn.rng.choice([0.0, 0.5]) + drawn.rng.uniform(-0.1, 0.1)

    def add(seen: Stimulus, triad: TriadInput) -> np.ndarray:
        size = np.linalg.norm(seen.f, axis=1, keepdims=True)
        north, east = level_axes(seen.f, seen.magnetic, drawn.truth.magnetic_enu_ut)
        swing = np.sin(2 * np.pi * (seen.t / DAY_S + phase)) - np.sin(2 * np.pi * phase)
        tilts = drawn.size * URAD * swing * size * (np.sin(azimuth) * east + np.cos(azimuth) * north)
        return np.asarray(tilts @ drawn.truth.accel_e.T)

    return {"accel": add}


def unit_slips(drawn: Drawn) -> Adds:
    """The unit slips on its dowels while the cube is carried: turned by so much in every step from t1 on."""
    r, when = drawn.size * URAD * drawn.direction(), drawn.rng.uniform(500, 1500)
    return drawn.turned(lambda seen: r[None] * float(seen.t[0, 0] > when))


_KINDS = (
    Kind("K3 of a pendulum", "1293 8.3, K3", "free", (4.0, 40.0), "ug/g^3", cubic,
         ("accelerometer.cubic",), (),
         "Free positions have inputs between 0 and 1 g, where u^3 is no other term of the catalogue."),
    Kind("K_po of a pendulum", "1293 8.3, K_po", "free", (10.0, 60.0), "ug/g^2", pendulum_product,
         ("accelerometer.cross_product",), (), "The product of the two other axes is a coefficient of that term."),
    Kind("wavelength over temperature", "Lefevre, ch. 8; 952, sensitivity of the scale factor to temperature",
         "two temperatures", (5.0, 50.0), "ppm/K", wavelength, ("gyroscope.scale_temperature",), (),
         "1 / (1 + x) - 1 is -x within x^2, here below 1 ppm; each campaign has one temperature."),
    Kind("magnet lags the thermometer", "1293 5.3, scale factor over temperature", "warm", (20.0, 120.0), "ppm/K",
         magnet_lags, ("accelerometer.scale_temperature_lag",), (),
         "Slopes within a dwell separate it from a scale factor without a lag (three powers of temperature "
         "correlate by 0.80 to 0.99); a bias that lags would have one sign on a face and on its opposite."),
    Kind("accelerometer warms up", "1293 5.3, warm-up", "plain", (20.0, 200.0), "ug", accelerometer_warms_up,
         ("accelerometer.bias_settling",), (), "An exponential of the time since power-on is just this term."),
    Kind("mode hop of the source", "Lefevre, ch. 8, the source's spectrum", "speeds", (30.0, 300.0), "ppm",
         mode_hop, ("gyroscope.jump",), (),
         "A step of the scale factor is a form of the jump; a settling correlates by 0.4 to 0.8."),
    Kind("Shupe effect of coil and spool",
         "Shupe 1980, Appl. Opt. 19, 654: integral of (L - 2 z) dT/dt along the fibre; Lefevre, ch. 6", "soak",
         (0.5, 4.0), "deg/h/(K/min)", shupe_of_two,
         ("gyroscope.temperature_rate_lag", "gyroscope.temperature_rate", "gyroscope.temperature_lag"),
         ("gyroscope.bias_temperature",),
         "dT1/dt = (T - T1) / tau1 is a bias over temperature less one that lags: these names build it together "
         "(correlation above 0.998), and what one of them leaves (the rate alone: 0.92) may stay nameless."),
    Kind("dead time of a converter", "Scheeline, V-to-F converters, asdlib.org; 1293 8.3, odd quadratic K_oq",
         "free", (2.0, 20.0), "ns", dead_time, (), ("accelerometer.cubic",),
         "-k td u abs(u): with a scale factor it correlates with u^3 by 0.995 at the inputs of free positions."),
    Kind("scale factor hysteresis over temperature", "1293 5.3, hysteresis over temperature", "warm",
         (10.0, 60.0), "ppm", scale_hysteresis, (), (),
         "The play of the catalogue is a bias, which has one sign on a face and on its opposite; three powers of "
         "temperature of the scale factor correlate by 0.98 at most, a lag of it by 0.85, and leave the rest."),
    Kind("asymmetry over temperature", "1293 8.3, K1', each coefficient over temperature", "warm", (2.0, 20.0),
         "ppm/K", asymmetry_warms, (), (),
         "It is a bias over temperature that is absent at 0 g: no term of temperature depends on the size of the "
         "input (correlation below 0.9), and asymmetry and K2 do not follow temperature."),
    Kind("hands warm the coil", "Shupe 1980; 952, drift by a gradient that changes with time", "plain", (1.0, 6.0),
         "deg/h", hand_heat, (), (),
         "The thermometer sees nothing of it, and the catalogue has a relaxation of accelerometers alone."),
    Kind("flicker of the voltage reference", "952 annex C, bias instability; Keshner 1982, Proc. IEEE 70, 212",
         "plain", (1.0, 8.0), "ug", flicker, (), ("accelerometer.bias_walk",),
         "A walk of the bias is the form of any slow noise and names no cause; a jump or a drift is wrong."),
    Kind("floor leans by day", "1293 11, test station; Kohl and Levine 1993, J. Res. NIST 98, 191", "plain",
         (20.0, 100.0), "urad", floor_tilts, (), ("placement.scatter",),
         "The plate's tilt, which the model holds, is what changes: by the dwells alone each stands with a tilt "
         "of its own. An error of an accelerometer is wrong."),
    Kind("fixture twists with temperature", "1293 5.3, misalignment over temperature; TW, ch. 8", "warm",
         (2.0, 15.0), "urad/K", fixture_twists, (), (),
         "Both triads turn alike in the cube within a dwell: no placement, which is still, and no bias, which "
         "does not follow the attitude."),
    Kind("unit slips in the fixture", "1293 11, mounting; TW, ch. 8", "plain", (50.0, 300.0), "urad", unit_slips,
         ("placement.tilt",), (),
         "A turn of the unit from a moment on is what that name says; a jump of accelerometers is wrong, because "
         "what is seen goes with the attitude."),
)  # fmt: skip
LITERATURE: dict[str, Kind] = {kind.name: kind for kind in _KINDS}
