"""The site and the clock: where North is, latitude, gravity, how long a sample lasts."""

from collections.abc import Callable

import numpy as np

from procedures.effects.effect import Effect
from procedures.effects.excitation import Columns, Excitation
from procedures.effects.surface_plate import world_rotation_columns
from procedures.frames import AXES
from procedures.units import STANDARD_GRAVITY


def _earth_turned(about: str) -> Callable[[Excitation], list[Columns]]:
    """Return columns of the Earth's rate turned about an axis of the slab [deg/s per rad], in turns too."""

    def columns(excitation: Excitation) -> list[Columns]:
        axis = np.eye(3)[:, [AXES.index(about)]]
        _, gyro, rotation = world_rotation_columns(excitation, axis)
        return [Columns(("value",), gyro=gyro, rotation=rotation)]

    return columns


AZIMUTH = Effect(
    name="site.azimuth",
    meaning="Azimuth error of the surface plate's North mark, positive to the east",
    about=(
        "Horizontal Earth rate comes from elsewhere. Seen by the gyroscopes alone; a heading error of one step "
        "is one draw, this is common to all. Plausible: 0.02 rad, a slab aligned by compass."
    ),
    unit="rad",
    physics="the surface plate's North mark points east of true north: C_ln turns about the vertical",
    source="IEEE Std 952, Earth rate as input in the multiposition test",
    plausible=0.02,
    columns=_earth_turned("z"),
    next_measurement="survey",
    separate_by="a survey of the surface plate's North mark",
)


def gravity_columns(excitation: Excitation) -> list[Columns]:
    """Return the vertical in every campaign [g per m/s2]; ``where`` numbers campaigns from 1."""
    up = excitation.f / np.linalg.norm(excitation.f, axis=1)[:, None]
    campaign = excitation.per_step("campaign")
    return [
        Columns(
            ("value",),
            accel=np.where(campaign == number, 1.0, 0.0)[:, None, None] * up[:, :, None] / STANDARD_GRAVITY,
            where={"campaign": int(number) + 1},
        )
        for number in np.unique(campaign)
    ]


GRAVITY = Effect(
    name="site.gravity",
    meaning="Error of the stated gravity, true less stated",
    about=(
        "More specific force along up. One with the scale factors of all accelerometers. Plausible: 1e-3 m/s2, "
        "normal gravity's error over rough country."
    ),
    unit="m/s^2",
    physics="value / 9.80665 along up",
    source="Yao, Hu, He 2018, eq. (1): the reference is local gravity",
    plausible=1e-3,
    columns=gravity_columns,
    next_measurement="survey",
    separate_by="a gravimetric survey of the site, or the same unit at a surveyed one",
    is_held_at_prior=True,
)


LATITUDE = Effect(
    name="site.latitude",
    meaning="Error of the stated latitude, true less stated",
    about=(
        "The Earth's rate dips by another angle. Seen by the gyroscopes alone: gravity is stated on its own. "
        "Omega = W (0, cos L, sin L) in East-North-Up; its change with L, W (0, -sin L, cos L), is a small "
        "rotation about East. Plausible: 0.02 rad, 1 deg."
    ),
    unit="rad",
    physics="latitude + value in the Earth's rate W (0, cos L, sin L)",
    source="IEEE Std 952, Earth rate as input in the multiposition test",
    plausible=0.02,
    columns=_earth_turned("x"),
    next_measurement="survey",
    separate_by="the latitude of the bench from a map or a receiver, in campaign.toml",
)


def clock_columns(excitation: Excitation) -> list[Columns]:
    """Return the output at rest and on a rate table less a millionth [g, deg/s per ppm]."""
    moved = np.array([step.kind in {"turn", "move"} for step in excitation.steps])[excitation.step]
    gyro = np.where(moved[:, None], 0.0, -1e-6 * excitation.gyro_output)
    return [Columns(("value",), accel=-1e-6 * excitation.accel_output[:, :, None], gyro=gyro[:, :, None])]


CLOCK_RATE = Effect(
    name="clock.rate",
    meaning="Rate error of the device's clock, positive where fast",
    about=(
        "Its sample lasts dt / (1 + 1e-6 value) of true seconds. Counts per stated second fall by that much, of "
        "the whole output E u + D. The accelerometers' scale factor takes all of it, and a closed turn or a move "
        "is the same angle by any clock (what is left of it there is a millionth of Earth rate and bias), so the "
        "evidence proper is elsewhere: reference time utc_s and the mean period. Plausible: 100 ppm, a crystal "
        "without compensation."
    ),
    unit="ppm",
    physics="a sample lasts dt / (1 + 1e-6 value)",
    source="IEEE Std 1139, fractional frequency",
    plausible=100.0,
    columns=clock_columns,
    next_measurement="reference_time",
    separate_by="reference time (utc_s) recorded with the counts",
    multiplies_output=True,
)
