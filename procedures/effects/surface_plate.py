"""The surface plate under the cube: attitudes on it, its tilt, headings and closures that scatter."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Effect
from procedures.effects.excitation import Columns, Excitation
from procedures.frames import rotation
from procedures.positions import nominal_C_lb


def slab_C_il(excitation: Excitation, *, at_ends: bool = False) -> FloatArray:
    """Return the nominal rotation (n, 3, 3) from the slab's marks to the IMU; zeros of steps in no position.

    In a turn the heading is what the rate about the vertical came to since the step began; ``at_ends``: as a turn
    ends, and where it began.
    """
    C_il = np.zeros((len(excitation.t), 3, 3))
    for number, step in enumerate(excitation.steps):
        nodes = np.flatnonzero(excitation.step == number)
        if not step.position or not len(nodes):
            continue
        C = excitation.C_sb[nodes[0]] @ nominal_C_lb(step.position).T
        C_il[nodes] = C
        if step.kind == "turn" and not at_ends:
            rate = np.radians(excitation.omega[nodes] @ C[:, 2])
            seconds = np.gradient(excitation.rest_s[nodes])
            heading = np.cumsum(rate * seconds) - rate * seconds / 2
            about = np.zeros((len(nodes), 3))
            about[:, 2] = -heading
            C_il[nodes] = C @ rotation(about)
    return C_il


def world_rotation_columns(
    excitation: Excitation, rotation_l: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return accelerometer and gyroscope columns (n, 3, k) of small rotations of all but the slab, and those.

    The rotation vectors ``rotation_l`` (3, k) are in the slab's marks and turn gravity and Earth rate as the slab
    sees them; a hand turn's own rate stays. Nought of steps in no position.
    """
    C_il = slab_C_il(excitation)
    turned = C_il @ rotation_l
    earth = np.einsum("nil,nl->ni", C_il, _earth_l(excitation, C_il))
    accel = excitation.E_accel @ np.cross(turned, excitation.f[:, :, None], axis=1)
    gyro = excitation.E_gyro @ np.cross(turned, earth[:, :, None], axis=1)
    away = np.array([not step.position for step in excitation.steps])[excitation.step]
    accel[away], gyro[away] = 0.0, 0.0
    return accel, gyro, slab_C_il(excitation, at_ends=True) @ rotation_l


def _earth_l(excitation: Excitation, C_il: FloatArray) -> FloatArray:
    """Return the Earth rate (n, 3) [deg/s] in the slab's marks, as the campaign's rests in positions see it."""
    found = np.zeros_like(excitation.omega)
    rests = np.array([step.position > 0 and step.kind != "turn" for step in excitation.steps])[excitation.step]
    campaign = excitation.per_step("campaign")
    for number in np.unique(campaign):
        here = campaign == number
        if (seen_at := here & rests).any():
            found[here] = np.einsum("nil,ni->nl", C_il[seen_at], excitation.omega[seen_at]).mean(axis=0)
    return found


ROTATION = np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 0.0]])  # up goes east by a turn about north: `slab_C_ln`


def tilt_columns(excitation: Excitation) -> list[Columns]:
    """Return the world turned about the slab's North and East."""
    accel, gyro, rotation = world_rotation_columns(excitation, ROTATION)
    return [Columns(("east", "north"), accel=accel, gyro=gyro, rotation=rotation)]


TILT = Effect(
    name="slab.tilt",
    meaning="Tilt of the surface plate",
    about=(
        "Every vector of the world turns as the slab sees it. Coefficients are the East and North components of "
        "the up vector seen from the slab. Plausible: 5e-3 rad, 0.3 deg."
    ),
    unit="rad",
    physics="up in the surface plate's axes = (east, north, 1)",
    source="Yao, Hu, He 2018, section 2: positions in pairs turned by 180 deg",
    plausible=5e-3,
    columns=tilt_columns,
    next_measurement="again",
    separate_by="both positions of every face, turned by 180 deg",
    is_bench_parameter=True,
)


TIMES_STATED = 2.0


def heading_columns(excitation: Excitation) -> list[Columns]:
    """Return every dwell turned by a degree about the slab's normal [g and deg/s per deg]."""
    names, plausible = list[str](), list[float]()
    level, turned, about = list[FloatArray](), list[FloatArray](), list[FloatArray]()
    C_il = slab_C_il(excitation)
    earth = np.radians(np.cross(C_il[:, :, 2], excitation.omega))
    for number, step in enumerate(excitation.steps):
        nodes = excitation.step == number
        if step.kind == "dwell" and step.stated_std > 0:
            from_east, from_north = step.slab_tilt
            tilted = np.radians(C_il @ np.array([-from_north, from_east, 0.0]))
            level.append(np.where(nodes[:, None], tilted, 0.0))
            turned.append(np.where(nodes[:, None], earth, 0.0))
            about.append(np.where(nodes[:, None], np.radians(C_il[:, :, 2]), 0.0))
            names.append(f"{step.campaign + 1}.{step.name}")
            plausible.append(TIMES_STATED * float(np.degrees(step.stated_std)))
    if not names:
        return []
    accel, gyro, rotation = (np.stack(parts, axis=2) for parts in (level, turned, about))
    accel, gyro = excitation.E_accel @ accel, excitation.E_gyro @ gyro
    return [Columns(tuple(names), accel=accel, gyro=gyro, rotation=rotation, plausible=tuple(plausible))]


HEADING = Effect(
    name="procedure.heading",
    meaning="Headings of placements scatter more than stated",
    about=(
        "A turn about the vertical in each dwell, a fitted variance. The gyroscopes see it by the Earth's "
        "horizontal rate, accelerometers by the tilt of the slab. Plausible: twice what is stated."
    ),
    unit="deg",
    physics="every placement is turned at random, standard deviation = value about the vertical",
    source="IEEE Std 952, alignment errors of the multiposition test",
    plausible=0.2,
    columns=heading_columns,
    next_measurement="twice",
    separate_by="the positions again, against a stop on the surface plate",
    is_scatter=True,
)


def closure_columns(excitation: Excitation) -> list[Columns]:
    """Return a degree more turned in each turn [deg/s per deg], spread evenly over the turn, and at its end."""
    names, parts, ends, plausible = list[str](), list[FloatArray](), list[FloatArray](), list[float]()
    up = slab_C_il(excitation)[:, :, 2]
    for number, step in enumerate(excitation.steps):
        nodes = excitation.step == number
        if step.kind == "turn" and step.stated_std > 0 and nodes.sum() > 1:
            seconds = float(np.gradient(excitation.rest_s[nodes]).sum())
            parts.append(np.where(nodes[:, None], up / seconds, 0.0))
            last = np.arange(len(nodes)) == np.flatnonzero(nodes)[-1]
            ends.append(np.where(last[:, None], -np.radians(up), 0.0))
            names.append(f"{step.campaign + 1}.{step.name}")
            plausible.append(TIMES_STATED * float(np.degrees(step.stated_std)))
    if not parts:
        return []
    gyro = excitation.E_gyro @ np.stack(parts, axis=2)
    return [Columns(tuple(names), gyro=gyro, rotation=np.stack(ends, axis=2), plausible=tuple(plausible))]


CLOSURE = Effect(
    name="procedure.closure",
    meaning="Closure errors of rotations larger than stated",
    about=(
        "Each comes back to where it began but for a draw of its own, a fitted variance. A turn about the slab's "
        "normal n adds its angle along n, as the gyroscopes see it. Plausible: twice what is stated."
    ),
    unit="deg",
    physics="every rotation has a random closure error, standard deviation = value about the plate's normal",
    source="Yao, Hu, He 2018, section 2: whole turns from a mark back to it",
    plausible=0.04,
    columns=closure_columns,
    next_measurement="more_revolutions",
    separate_by="the six rotations again with three times the revolutions: a closure error stays, an error of the "
    "scale factor grows with the angle",
    is_scatter=True,
)
