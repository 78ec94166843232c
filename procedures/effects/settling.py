"""What settles, drifts or cycles in time: biases and scale factors since power-on, accelerometers after a flip."""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from procedures.effects.effect import effect_of, twins
from procedures.effects.excitation import PERIOD, TAU, Columns, Excitation, search
from procedures.effects.jump import block_times, soak_of
from procedures.effects.temperature_history import since_begun
from procedures.effects.term.law import Law, Parameter
from procedures.statistics.spectrum import MIN_PERIODS

SHORTEST_S, SHORTEST_AT_REST_S = 30.0, 3.0  # s, of a time constant to begin with
BY_CHANGE, BY_FORCE = "by the change of f", "by f"
FITTED = {TAU: Parameter("s")}


def _since_power_on(seen: Excitation) -> Iterator[Columns]:
    """Yield the time constants that a search begins with; none where no time is known."""
    since = since_begun(seen)
    if np.isfinite(since).all():
        for tau in search(SHORTEST_S, float(since.max())):
            yield Columns((), nonlinear={TAU: tau})


def _at_rest(seen: Excitation) -> Iterator[Columns]:
    """Yield every shape with time constants to begin with; none of a campaign without rests."""
    rests = np.array([step.kind in {"dwell", "rest"} for step in seen.steps])[seen.step]
    for tau in search(SHORTEST_AT_REST_S, float(np.max(seen.rest_s[rests], initial=0.0))):
        for shape in ("", BY_CHANGE, BY_FORCE):
            yield Columns((), shape=shape, nonlinear={TAU: tau})


ACCELEROMETER_DRIFT, GYROSCOPE_DRIFT = twins(
    "bias_drift",
    Law(terms=("t",)),
    unit=("g/h", "deg/h/h"),
    plausible=(1e-4, 0.5),
    meaning="Drift of a bias in time",
    about="The bias refers to t = 0 of the device's time. Where temperature only rises, drift and temperature "
    "are one. Plausible, of a unit just switched on: 100 ug/h of the accelerometers, 0.5 deg/h/h of the "
    "gyroscopes.",
    source=("IEEE Std 1293, bias trend", "IEEE Std 952, drift rate ramp"),
    separate_by="a second campaign in another order, or a heating run up and down again",
)

BIAS = Law(terms=(f"exp(-t_on / {TAU})",), parameters=FITTED)
ACCELEROMETER_BIAS, GYROSCOPE_BIAS = twins(
    "bias_settling",
    BIAS,
    unit=("g", "deg/h"),
    plausible=(2e-4, 1.0),
    starts=_since_power_on,
    meaning="Bias that settles after power-on",
    about="Electronics, servo loop and source come to their temperature by their own heat after power-on, and a "
    "bias with them: the warm-up time of a data sheet. A thermometer of the case need not see it. t_on is the "
    "time since the first sample. One time constant for the triad, fitted; of one far longer than what was "
    "recorded it is a drift. c is what is left of it when a recording begins, since when the power was on nobody "
    "records. Plausible: 200 ug and 1 deg/h, as of units that are ten times as stable when warm.",
    source=("IEEE Std 1293, warm-up time and bias stability", "IEEE Std 952, warm-up time and turn-on bias"),
    separate_by="the campaign once more, in another order, when the unit has been on for an hour",
    next_measurement="repeat",
)

MIN_BLOCKS = 2 * int(MIN_PERIODS)  # of a soak: of fewer a cycle that no spectrum shows would look like a slow one
MIN_CYCLES = 1.5  # in what was recorded: less is a drift
PER_CYCLE = 2  # steps of a frequency in 1 / T: between two of them a sine keeps 81 % of its power
MAX_PERIODS = 50  # to begin with, to 26 cycles: from 16 on the spectrum of the samples shows lines


def most_cycles(blocks: int) -> float:
    """Return how many cycles the means of a soak's blocks show; of one in two blocks they miss a phase."""
    return (blocks - 1) / 2


def _cycles(seen: Excitation) -> Iterator[Columns]:
    """Yield the periods that a search begins with; none without a soak, or where no time is known."""
    since, times = since_begun(seen), block_times(seen)
    blocks = Counter((step.campaign, soak_of(step)) for step in times)
    longest, most = max(blocks.items(), key=lambda each: each[1], default=(None, 0))
    if most < MIN_BLOCKS or not np.isfinite(since).all():
        return
    soak_s = sum(seconds for step, (_, seconds) in times.items() if (step.campaign, soak_of(step)) == longest)
    recorded_s, first = float(since.max() + since.min()), round(PER_CYCLE * MIN_CYCLES)
    last = int(PER_CYCLE * most_cycles(most) * recorded_s / soak_s + 1e-6)
    for number in range(first, min(last, first + MAX_PERIODS - 1) + 1):
        yield Columns((), nonlinear={PERIOD: PER_CYCLE * recorded_s / number})


ACCELEROMETER_CYCLE, GYROSCOPE_CYCLE = twins(
    "bias_cycle",
    Law(
        terms=tuple(f"{sine}(2 * pi * t_on / {PERIOD})" for sine in ("sin", "cos")),
        suffixes=(".sin", ".cos"),
        parameters={PERIOD: Parameter("s")},
    ),
    unit=("g", "deg/h"),
    plausible=(1e-4, 0.5),
    starts=_cycles,
    meaning="Periodic change of a bias",
    about="Air conditioning or a thermostat warm the unit and let it cool, and no thermometer was read that shows "
    "it; where one was, the bias follows that. t_on is the time since the first sample. One period for the triad, "
    "fitted. It is looked for in a soak of 32 blocks or more, from two blocks to 1 / 1.5 of what was recorded: "
    "a slower one is a drift, a faster one a line of the samples. Plausible: 100 ug and 0.5 deg/h, as of a room "
    "that cycles by a kelvin.",
    source=("IEEE Std 1293, bias, environmental sensitivity", "IEEE Std 952, bias, environmental sensitivity"),
    separate_by="the temperature recorded with the samples, or the same recording with the air conditioning off",
    next_measurement="steady_room",
)

SCALE = Law(terms=(f"exp(-t_on / {TAU}) * out_changing",), parameters=FITTED)
ACCELEROMETER_SCALE, GYROSCOPE_SCALE = twins(
    "scale_settling",
    SCALE,
    unit="ppm",
    plausible=300.0,
    starts=_since_power_on,
    meaning="Scale factor that settles after power-on",
    about="The wavelength of a FOG's source settles after power-on as its own junction and its cooler do, and "
    "the Sagnac phase goes with 1 / wavelength; an accelerometer's torquer magnet and pendulum come to their "
    "temperature by their own heat. No thermometer of the case needs to see either. t_on is the time since the "
    "first sample. One time constant for the triad, fitted; of one far longer than what was recorded it is a "
    "straight line, a scale factor that ages. c is what is left of it when a recording begins, since when the "
    "power was on nobody records. It shows where the input of a sensor changes: where it stands, a bias does the "
    "same, and out_changing is zero. Plausible: 300 ppm, a source of 400 ppm/K without a cooler that warms by a "
    "kelvin.",
    source=(
        "IEEE Std 1293, warm-up time and scale factor stability; torquer magnet and pendulum warm up",
        "IEEE Std 952, warm-up time and scale factor stability; the source's wavelength after power-on",
    ),
    separate_by="the campaign once more, in another order, when the unit has been on for an hour",
    next_measurement="repeat",
)

FADING = f"exp(-t_rest / {TAU})"
RELAXATION = effect_of(
    "accelerometer.relaxation",
    Law(terms=(FADING,), parameters=FITTED),
    Law(terms=(f"{FADING} * (f - f_before)",), parameters=FITTED, shape=BY_CHANGE, unit="g/g"),
    Law(terms=(f"{FADING} * f",), parameters=FITTED, shape=BY_FORCE, unit="g/g"),
    unit="g",
    plausible=1e-4,
    starts=_at_rest,
    meaning="Relaxation of the accelerometers after a flip",
    about="Flexure and suspension creep after the load on them changed. c is the same after every flip, or in "
    "proportion to the change of specific force along the axis, or to the specific force that is. tau is fitted. "
    "t_rest is the time since the step began: the cube comes to rest before, and c is what is left at its "
    "beginning. Plausible: 100 ug.",
    source="IEEE Std 1293, hysteresis and warm-up trend after tumbling",
    separate_by="a long dwell after a flip, and one without a flip before it",
)
