"""How the cube was placed: seatings off, seatings that scatter, a wrong position, a shock."""

import numpy as np

from procedures.effects.effect import Effect
from procedures.effects.excitation import Columns, Excitation, rotation_columns
from procedures.frames import AXES
from procedures.positions import cross_axes


def dwell_columns(excitation: Excitation) -> list[Columns]:
    """Return each dwell in a position turned about the cube's axes; ``where`` names position and file."""
    several = len({step.campaign for step in excitation.steps}) > 1
    turned = (*rotation_columns(excitation, excitation.C_sb), excitation.C_sb)
    found = list[Columns]()
    for number, step in enumerate(excitation.steps):
        if step.position and step.kind != "turn":
            here = excitation.step == number
            accel, gyro, rotation = (np.where(here[:, None, None], each, 0.0) for each in turned)
            where: dict[str, object] = {"position": step.position, "file": step.name}
            if several:  # whose files may share their names
                where["campaign"] = step.campaign + 1
            found.append(Columns(AXES, accel=accel, gyro=gyro, rotation=rotation, where=where))
    return found


DWELL = Effect(
    name="placement.dwell",
    meaning="Tilted seating of the cube in one dwell",
    about=(
        "In one dwell the cube stands turned by a small rotation, dirt or a chip under it. The rotation vector "
        "is in the cube's axes and turns every vector as the cube sees it. Where faces are free, a seating and "
        "that of the position on the same face cannot be separated. Plausible: 5e-4 rad, 0.2 mm on 400 mm."
    ),
    unit="rad",
    physics="rotation(x, y, z) of every vector as seen in the cube, in one dwell",
    source="Yao, Hu, He 2018, section 2: the cube seated on its face",
    plausible=5e-4,
    columns=dwell_columns,
    next_measurement="again",
    separate_by="the same position again, with plate and face wiped",
    is_turn=True,
)


def rest_columns(excitation: Excitation) -> list[Columns]:
    """Return each rest in a free attitude with another specific force [g], along the one it should have seen."""
    found, up = list[Columns](), excitation.f / np.linalg.norm(excitation.f, axis=1, keepdims=True)
    for number, step in enumerate(excitation.steps):
        here = excitation.step == number
        if step.kind == "rest" and not step.position and np.isfinite(up[here]).all():
            t = excitation.t[here]
            where: dict[str, object] = {"file": step.name, "from_s": float(t[0]), "to_s": float(t[-1])}
            found.append(Columns(("value",), accel=np.where(here[:, None], up, 0.0)[:, :, None], where=where))
    return found if len(found) >= MIN_RESTS else []


MIN_RESTS = 10  # in free attitudes: with fewer every one is needed to determine the accelerometers
REST = Effect(
    name="disturbance.rest",
    meaning="One rest disturbed",
    about=(
        "In one rest in a free attitude the unit was touched, still moved or stood on something that did, or its "
        "row is wrong: the specific force there is not gravity's. Plausible: 1 mg, a hand on the table."
    ),
    unit="g",
    physics="value f / |f| in one rest",
    source="IEEE Std 1293, test disturbances",
    plausible=1e-3,
    columns=rest_columns,
    driver="time at rest",
    next_measurement="again",
    separate_by="the same rest again",
)


LABEL = Effect(
    name="placement.label",
    meaning="Wrong position or direction recorded",
    about=(
        "The cube stood in another one than its dwell says. Not small, so no column: vectors differ by quarter "
        "and half turns. Found where a dwell fits another position better. The coefficient is the position where "
        "it stood, so that any of 1 to 12 is plausible."
    ),
    unit="position",
    physics="the cube stands in position `actual`",
    source="Yao, Hu, He 2018, table 1",
    plausible=12.0,
    next_measurement="again",
    separate_by="the same position again",
)


def scatter_columns(excitation: Excitation) -> list[Columns]:
    """Return each dwell and turn tilted about the two level axes of the cube [g and deg/s per rad]."""
    seats = [
        (number, step, axis)
        for number, step in enumerate(excitation.steps)
        if step.position and step.kind in {"dwell", "turn"}
        for axis in cross_axes(step.face)
    ]
    if not seats:
        return []
    tilted = np.zeros((len(excitation.t), 3, len(seats)))
    for i, (number, _, axis) in enumerate(seats):
        here = excitation.step == number
        tilted[here, :, i] = excitation.C_sb[here, :, axis]
    names = [f"{step.campaign + 1}.{step.name}.{AXES[axis]}" for _, step, axis in seats]
    accel, gyro = rotation_columns(excitation, tilted)
    return [Columns(tuple(names), accel=accel, gyro=gyro, rotation=tilted)]


SCATTER = Effect(
    name="placement.scatter",
    meaning="Scatter of the seating tilt",
    about=(
        "In every dwell and turn the IMU in the cube, or the cube on the slab, is tilted by its own draw. One "
        "variance for both level axes, fitted. A turn then goes about another axis of the IMU. Plausible: 1e-4 "
        "rad, 0.04 mm on 400 mm."
    ),
    unit="rad",
    physics="every seating is tilted at random, standard deviation = value about each level axis",
    source="IEEE Std 1293, repeatability of mounting in the multiposition test",
    plausible=1e-4,
    columns=scatter_columns,
    next_measurement="twice",
    separate_by="the positions again, each seated several times: the seating changes, the sensor does not",
    is_scatter=True,
)


DISTURBANCE = Effect(
    name="disturbance.dwell",
    meaning="Shock or vibration while at rest",
    about=(
        "A shock, a footstep, a machine nearby. It averages out of the counts' mean, or nearly: what shows it is "
        "their variance, over short stretches of the dwell, and so it has no column. Plausible: 0.01 g, what a "
        "shock on the plate gives."
    ),
    unit="g",
    physics="an output that comes and goes within a rest",
    source="IEEE Std 1293, seismic noise of the test site",
    plausible=1e-2,
    next_measurement="again",
    separate_by="the same position again, with nobody near the surface plate",
)
