"""What temperature does to biases and scale factors: polynomials, lags, its rate, hysteresis.

Polynomials are of the temperature above 25 degC, one a sensor, each of its own order, which the data determine
(`procedures.inference.hypotheses`). The coefficient of the n-th power is plausibly as large as makes it as much as
the first at 30 K from the reference.
"""

from collections.abc import Iterator

import numpy as np

from procedures.effects.effect import effect_of, twins
from procedures.effects.excitation import PLAY, TAU, Columns, Excitation, search
from procedures.effects.temperature_history import ranged_k, recorded_s
from procedures.effects.term.law import Law, Parameter
from procedures.frames import AXES

FIRST_ORDERS = (1, 2, 3)  # with which a search begins
FIRST_LAGGED_ORDERS = (1, 2, 3)
SHORTEST_S = 20.0  # s, of a time constant to begin with: shorter ones show in the temperature's rate
SMALLEST_K = 0.3  # half width of a play that a search begins with: smaller ones turn at once
LARGEST = 0.5  # of the range of temperature: a wider play is a coefficient of temperature
RATIO = 1.7  # between neighbours
WITH_PLAY = "with a play"


def _orders(seen: Excitation) -> Iterator[Columns]:
    for order in FIRST_ORDERS:
        yield Columns((), orders=(order,) * len(AXES))


def _lags(seen: Excitation) -> Iterator[Columns]:
    """Yield lines and parabolas with the time constants of a first search; none of an unknown temperature."""
    if np.isfinite(seen.temperature).all():
        for order in FIRST_LAGGED_ORDERS:
            for tau in search(SHORTEST_S, recorded_s(seen)):
                yield Columns((), orders=(order,) * len(AXES), nonlinear={TAU: tau})


def _rate_lags(seen: Excitation) -> Iterator[Columns]:
    """Yield time constants of a first search; none of an unknown temperature."""
    if np.isfinite(seen.temperature).all():
        for tau in search(SHORTEST_S, recorded_s(seen)):
            yield Columns((), nonlinear={TAU: tau})


def _plays(seen: Excitation) -> Iterator[Columns]:
    """Yield the direction alone, and half widths of a play that a search begins with."""
    yield Columns(())
    width = SMALLEST_K
    while width <= LARGEST * ranged_k(seen):
        yield Columns((), shape=WITH_PLAY, nonlinear={PLAY: width})
        width *= RATIO


LAGGED = {TAU: Parameter("s")}
ACCELEROMETER_BIAS, GYROSCOPE_BIAS = twins(
    "bias_temperature",
    Law(terms=("T**n",)),
    unit=("g/K", "deg/h/K"),
    plausible=(1e-4, 0.3),
    starts=_orders,
    meaning="Temperature coefficients of a bias",
    about="The order is found from the data, for each sensor. Plausible: 100 ug/K of the accelerometers; 0.3 "
    "deg/h/K of the gyroscopes, of a tactical FOG without compensation; a navigation one has a tenth of it.",
    source=("IEEE Std 1293, temperature sensitivity of bias", "IEEE Std 952, temperature sensitivity of bias"),
    separate_by="a heating run up and down again, or a second campaign in another order",
)

ACCELEROMETER_SCALE, GYROSCOPE_SCALE = twins(
    "scale_temperature",
    Law(terms=("T**n * out",)),
    unit="ppm/K",
    plausible=100.0,
    starts=_orders,
    meaning="Temperature coefficients of a scale factor",
    about="It multiplies the whole output, bias included; the order is found from the data, for each sensor. "
    "Plausible: 100 ppm/K, of a servo magnet without compensation as of a FOG: its source's mean wavelength goes "
    "by some 400 ppm/K where nothing holds it, the coil's length and index by 10 ppm/K.",
    source=(
        "IEEE Std 1293, temperature sensitivity of scale factor",
        "IEEE Std 952, temperature sensitivity of scale factor",
    ),
    separate_by=(
        "the faces up and down again at a second temperature, in another order",
        "the same turns again at a second temperature, or a rate table in a chamber",
    ),
    same_at_rest=("accelerometer.bias_temperature", "gyroscope.bias_temperature"),
)

ACCELEROMETER_RATE, GYROSCOPE_RATE = twins(
    "temperature_rate",
    Law(terms=("T_rate",)),
    unit=("g/(K/min)", "deg/h/(K/min)"),
    plausible=(2e-5, 3.0),
    meaning="Bias that follows the rate of the temperature",
    about="Of a FOG's coil it is the Shupe effect. With one single exponential T and dT/dt are one. Plausible: 3 "
    "deg/h/(K/min), of a coil wound quadrupolar and not potted; 20 ug/(K/min), of a proof mass' suspension "
    "between plates of two temperatures.",
    source=(
        "IEEE Std 1293, temperature-rate sensitivity of bias",
        "D. M. Shupe, Thermally induced nonreciprocity, Appl. Opt. 19 (1980) 654",
    ),
    separate_by="a heating run with ramps of different steepness, up and down, to the same temperature",
)

SHUPE_LAG = effect_of(
    "gyroscope.temperature_rate_lag",
    Law(terms=(f"(T - lag(T, {TAU})) / {TAU}",), parameters=LAGGED),
    unit="deg/h/(K/min)",
    plausible=3.0,
    starts=_rate_lags,
    meaning="Bias of the gyroscopes that follows the rate of the coil's own temperature",
    about="The coil follows the thermometer by tau dT_s/dt = T - T_s, and the Shupe effect goes by dT_s/dt. It is "
    "a temperature coefficient less one that lags, of equal size: (T - T_s) / tau. Two of them, of the coil and "
    "of its spool, are the usual thermal model of a FOG. Plausible: as without a lag.",
    source="D. M. Shupe, Thermally induced nonreciprocity, Appl. Opt. 19 (1980) 654; heat conduction, first order",
    separate_by="a heating run with ramps of different steepness and long plateaus, up and down",
)

ACCELEROMETER_BIAS_LAG, GYROSCOPE_BIAS_LAG = twins(
    "temperature_lag",
    Law(terms=(f"lag(T, {TAU})**n",), parameters=LAGGED),
    unit=("g/K", "deg/h/K"),
    plausible=(1e-4, 0.3),
    starts=_lags,
    meaning="Bias that follows the temperature with a lag",
    about="The sensor follows the thermometer by tau dT_s/dt = T - T_s, or a part of it does: with a "
    "temperature coefficient it is what the coil, the proof mass or a gradient lags behind. One time constant "
    "for the triad, fitted. A short one is a temperature coefficient with one of the rate, T_s = T - tau dT/dt. "
    "Plausible: as a bias' temperature coefficient.",
    source=(
        "IEEE Std 1293, temperature sensitivity of bias; heat conduction, first order",
        "IEEE Std 952, temperature sensitivity of bias; heat conduction, first order",
    ),
    separate_by="a heating run with ramps and long plateaus, up and down",
)

ACCELEROMETER_SCALE_LAG, GYROSCOPE_SCALE_LAG = twins(
    "scale_temperature_lag",
    Law(terms=(f"lag(T, {TAU})**n * out",), parameters=LAGGED),
    unit="ppm/K",
    plausible=100.0,
    starts=_lags,
    meaning="Scale factor that follows the temperature with a lag",
    about="tau dT_s/dt = T - T_s: a servo's magnet and a coil follow the thermometer, or a part of them does, by "
    "heat conduction. One time constant for the triad, fitted. It shows where an input stands while temperature "
    "moves: faces up and down, turns, or a rate table whose points have a time. Plausible: as a scale factor's "
    "temperature coefficient.",
    source=(
        "IEEE Std 1293, temperature sensitivity of scale factor; heat conduction, first order",
        "IEEE Std 952, temperature sensitivity of scale factor; heat conduction, first order",
    ),
    separate_by=(
        "faces up and down in turn while it warms and cools, and again at rest in temperature",
        "turns or a rate table while it warms and cools, and again at rest in temperature",
    ),
    same_at_rest=("accelerometer.temperature_lag", "gyroscope.temperature_lag"),
)

DIRECTION = Law(terms=("warming",))
BRANCH = Law(
    terms=(f"backlash(T, {PLAY})",), shape=WITH_PLAY, parameters={PLAY: Parameter("K", 0.05, 50.0)}
)  # fmt: skip
ACCELEROMETER_HYSTERESIS, GYROSCOPE_HYSTERESIS = twins(
    "temperature_hysteresis",
    DIRECTION,
    BRANCH,
    unit=("g", "deg/h"),
    plausible=(1e-4, 0.5),
    starts=_plays,
    meaning="Hysteresis of a bias between warming and cooling",
    of_shape={WITH_PLAY: "Hysteresis of a bias between warming and cooling, with backlash"},
    about="What mounting, adhesive and winding keep of the way they came. Either the direction turns at once "
    "where temperature has come back by half a kelvin, from the turning point on; or with a play, whose half "
    "width w is fitted: backlash(T, w) = (T - P) / w, where P follows T as soon as T is farther away than w "
    "(Krasnosel'skii and Pokrovskii 1989), so that it goes from one branch to the other in proportion while "
    "temperature comes back by 2 w. Of steady ramps it is the temperature's rate. Plausible: 100 ug and 0.5 "
    "deg/h, half of what opens between the two branches.",
    source=(
        "IEEE Std 1293, hysteresis of bias over temperature; Krasnosel'skii and Pokrovskii 1989, play",
        "IEEE Std 952, hysteresis of bias over temperature; Krasnosel'skii and Pokrovskii 1989, play",
    ),
    separate_by="a heating run up and down with ramps of different steepness and long plateaus",
)
