"""What acts from outside: specific force on gyroscopes, magnetic field, vibration, auxiliary channels."""

from typing import Any

import numpy as np

from procedures.effects.effect import Effect, effect_of
from procedures.effects.excitation import Columns, Excitation, without_gaps
from procedures.effects.term.law import Law
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S

G_SENSITIVITY = effect_of(
    "gyroscope.g_sensitivity",
    Law(terms=("f_x", "f_y", "f_z"), suffixes=tuple(AXES)),  # xy: sensor x, f_y
    unit="deg/h/g",
    plausible=3.0,
    meaning="g-sensitivity of the gyroscopes",
    about="Its vertical part follows the magnetic field's where the field's horizontal part is small, and with "
    "the axis vertical it is one with the Earth rate times a scale factor error (0.001 deg/h per 100 ppm).",
    source="IEEE Std 952, model equation: acceleration-sensitive drift",
    separate_by="the same positions with the magnetic field turned or shielded",
)
MAGNETIC = effect_of(
    "gyroscope.magnetic",
    Law(terms=("B_x", "B_y", "B_z"), suffixes=tuple(AXES)),
    unit="deg/h/uT",
    plausible=0.1,
    meaning="Magnetic sensitivity of the gyroscopes",
    about="By the Faraday effect in fibre that is not quite polarising. Needs the site's field. Its part along "
    "the vertical is one with g-sensitivity, and heading alone separates the two apart. Plausible: 0.1 deg/h/uT "
    "(10 deg/h per gauss), of a coil without shield.",
    source="IEEE Std 952, magnetic sensitivity; K. Hotate, K. Tabe, Appl. Opt. 25 (1986) 1086",
    separate_by="the same positions with the magnetic field turned or shielded",
)

VIBRATION: dict[str, Any] = {
    "meaning": "Vibration rectification",
    "about": "The mean follows the variance of the vibration from step to step: an accelerometer's own along its "
    "axis; a gyroscope's that of all accelerometers together, since a coil or a proof mass may be shaken along "
    "any axis. The variance is that of the samples in each dwell and rest: where a sample is a mean it is less "
    "than that of the motion, the faster that is the less. Within a recording, stretch by stretch: "
    "`procedures.samples.sample_rectification`. Plausible: 3 mg/g^2 and 20 deg/h/g^2, as of consumer devices.",
    "separate_by": "the same position with a shaker, or the noisy neighbour, switched on and off",
}  # fmt: skip
ACCELEROMETER_VIBRATION = effect_of(
    "accelerometer.vibration_rectification",
    Law(terms=("vibration",)),
    unit="g/g^2",
    plausible=3e-3,
    source="IEEE Std 1293 and 836, vibration rectification coefficient",
    **VIBRATION,
)
GYROSCOPE_VIBRATION = effect_of(
    "gyroscope.vibration_rectification",
    Law(terms=("vibration_x + vibration_y + vibration_z",)),
    unit="deg/h/g^2",
    plausible=20.0,
    source="IEEE Std 952, sensitivity to vibration",
    **VIBRATION,
)

KEYS = ("ax", "ay", "az", "gx", "gy", "gz")
ACCEL_RANGE, GYRO_RANGE = 1e-4, 1.0  # g, deg/h by one standard deviation of the channel


def channel_columns(excitation: Excitation) -> list[Columns]:
    """Return each channel per sensor [g per g/unit, deg/s per deg/h/unit]; ``where`` names it."""
    found = list[Columns]()
    for name, known in excitation.auxiliary.items():
        value = without_gaps(excitation, known)
        spread = float(np.std(value))
        if not spread > 0:
            continue
        acts = value[:, None, None]
        accel, gyro = acts * np.eye(3, 6), acts / DEG_H_PER_DEG_S * np.eye(3, 6, 3)
        ranges = (ACCEL_RANGE / spread,) * 3 + (GYRO_RANGE / spread,) * 3
        found.append(Columns(KEYS, accel=accel, gyro=gyro, where={"channel": name}, plausible=ranges))
    return found


CHANNEL = Effect(
    name="auxiliary.channel",
    unit="ax..az: g/unit, gx..gz: deg/h/unit",
    physics="c aux",
    meaning="An auxiliary channel acts on the sensors",
    about="The bias holds where the channel is zero. Slow channels have gaps: in between it is linear. A channel "
    "that a step does not have at all is not known, and then nothing is reported of it. Plausible: 100 ug and 1 "
    "deg/h by one standard deviation of what the channel did.",
    source="IEEE Std 952 and 1293, environmental sensitivities of the model equations",
    plausible=1.0,
    columns=channel_columns,
    separate_by="the channel changed on purpose while the cube rests",
    driver="channel",
    carried_with="unit",
)
