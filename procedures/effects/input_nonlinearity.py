"""What a sensor's own input does beyond the scale factor: powers, asymmetry, products, lost counts."""

from collections.abc import Iterator

import numpy as np

from procedures.effects.effect import Effect, effect_of, twins
from procedures.effects.excitation import KNEE, Columns, Excitation
from procedures.effects.term.law import Law, Parameter

QUADRATIC = effect_of(
    "accelerometer.quadratic",
    Law(terms=("u**2",)),
    unit="g/g^2",
    plausible=1e-4,
    meaning="Second-order nonlinearity of the accelerometers",
    about="On a cube's faces u is 0 or +-1 g, and K2 is one with the bias and the parallelism of the two other "
    "face pairs.",
    source="IEEE Std 1293, model equation: second-order nonlinearity K2",
    # A group with the bench has the bench's name: here it is the asymmetry, which no face tells, however mounted.
    separate_by="free positions near 45 deg",
)
CUBIC = effect_of(
    "accelerometer.cubic",
    Law(terms=("u**3",)),
    unit="g/g^3",
    plausible=5e-5,
    meaning="Third-order nonlinearity of the accelerometers",
    about="On a cube's faces u is 0 or +-1 g, where u^3 = u: K3 is one with the scale factor. Plausible: a "
    "pendulous accelerometer's K3 is 1 to 50 ug/g^3.",
    source="IEEE Std 1293, model equation: third-order nonlinearity K3",
    separate_by="free positions between the faces, near 45 deg",
)
ASYMMETRY = Law(terms=("0.5 * abs(u)",))
ACCELEROMETER_ASYMMETRY, GYROSCOPE_ASYMMETRY = twins(
    "scale_asymmetry",
    ASYMMETRY,
    unit="ppm",
    plausible=100.0,
    meaning="Asymmetry of a scale factor",
    about="c = (k+ - k-) / k. On a cube's faces abs(u) = u^2: of the accelerometers it is one with K2 there. "
    "Turns + and - at equal speeds leave that of the gyroscopes alone; at different speeds it is one with an "
    "even nonlinearity. Plausible: 100 ppm, as of an analogue servo loop whose digitiser has two references.",
    source=("IEEE Std 1293, scale-factor asymmetry", "IEEE Std 952, scale-factor asymmetry"),
    separate_by=(
        "free positions between the faces, near 45 deg",
        "turns at two speeds in each direction, or a rate table",
    ),
    next_measurement=("", "two_speeds"),
)
CROSS_PRODUCT = effect_of(
    "accelerometer.cross_product",
    Law(terms=("f_x * f_y", "f_x * f_z", "f_y * f_z"), suffixes=("xy", "xz", "yz")),  # xyz: sensor x, f_y f_z
    unit="g/g^2",
    plausible=2e-5,
    meaning="Cross products of the accelerometers",
    about="Zero on every face of a cube, where only one axis sees gravity: its columns are built at nominal "
    "attitude, since on fitted ones they would be copies of the faces' tilts. Plausible: 20 ug/g^2, a fifth of "
    "K2: a pendulum's cross terms come through its deflection, which is small against its own nonlinearity.",
    source="IEEE Std 1293, model equation: cross-coupling coefficients K_ip, K_io, K_po",
    separate_by="free positions near 45 deg about each axis",
)
SCALE_NONLINEARITY = effect_of(
    "gyroscope.scale_nonlinearity",
    Law(terms=("u * abs(u)",), shape="u |u|"),
    Law(terms=("u**3",), shape="u^3", unit="ppm/(deg/s)^2", plausible=3.0),
    unit="ppm/(deg/s)",
    plausible=100.0,
    meaning="Odd nonlinearity of the gyroscopes' scale factor",
    about="Turns at one speed put it into the scale factor. The cubic is also the first term of the Sagnac sine: "
    "one alias group. Plausible: 100 ppm/(deg/s), or 3 ppm/(deg/s)^2 as of an open loop that reaches 90 deg of "
    "phase at 300 deg/s.",
    source="IEEE Std 952, scale-factor nonlinearity",
    separate_by="turns at three speeds in each direction or a rate table; from a Sagnac sine (sin(s u) / s) only "
    "rates at which s u is near 1",
)

SLOWEST, FASTEST = 0.1, 0.95  # of the fastest rate, between which a search for the knee begins
RATIO = 1.4  # between neighbours, at most
MIN_FASTEST = 1.0  # deg/s: slower ones are no turning


def _knees(seen: Excitation) -> Iterator[Columns]:
    """Yield knees [deg/s] to begin with."""
    fastest = float(np.max(np.abs(seen.omega), initial=0.0))
    if fastest > MIN_FASTEST:
        count = 1 + int(np.ceil(np.log(FASTEST / SLOWEST) / np.log(RATIO)))
        for knee in np.geomspace(SLOWEST * fastest, FASTEST * fastest, count).tolist():
            yield Columns((), nonlinear={KNEE: knee})


ABOVE = f"-sign(out) * max(0, abs(out) - {KNEE})"
COUNTS_LOST = effect_of(
    "gyroscope.counts_lost",
    Law(terms=(ABOVE,), parameters={KNEE: Parameter("deg/s", MIN_FASTEST, 1e4)}),
    unit="ppm",
    plausible=1000.0,
    starts=_knees,
    meaning="Counts lost at high rates",
    about="A counter or a loop that no longer follows loses a share of its pulses from a rate on. The knee is "
    "fitted. Turns at one speed put it into the scale factor, and where a single speed lies above the knee its "
    "share and its knee are one. Where all are lost the range ends: saturation. Plausible: 1000 ppm.",
    source="IEEE Std 952, maximum input rate; saturation of a counter or loop",
    separate_by="turns at four speeds in each direction, or a rate table",
    is_loss=True,
    not_corrected="counts lost above a rate cannot be restored",
)
SATURATION = Effect(
    name="gyroscope.saturation",
    meaning="Saturation of the gyroscopes",
    about="The output stays as it is while the table turns faster. No column: beyond its range a sensor says "
    "nothing, and the points there are left out. Found where the output no longer follows at two rates or more. "
    "The coefficients are the rates at which it ends, on either side. Plausible: any.",
    unit="deg/s",
    physics="abs(out) <= c",
    source="IEEE Std 952, input rate limits",
    plausible=1000.0,
    driver="input",
    next_measurement="other_speeds",
    separate_by="a rate table within the range",
    not_corrected="beyond its range an output says nothing of the rate",
)
