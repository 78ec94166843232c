"""One sample of the joint filter, and a whole log: the same code."""

import math

from procedures.arrays import FloatArray
from procedures.attitude.joint_aids import airspeed, level_velocity, rest, true_heading
from procedures.attitude.joint_gnss_fix import remember, velocity_fix
from procedures.attitude.joint_state import SINCE_UPDATE, Settings, State
from procedures.attitude.joint_strapdown import LONG_GAP_S, correct, start, take
from procedures.attitude.joint_update import propagate
from procedures.attitude.kernel_options import inlined, kernel

NO_AID, AIRSPEED, GNSS = 0, 1, 2


@inlined
def advance(
    s: State, c: Settings, aid: int, dt: float, rate: FloatArray, force: FloatArray, air: float, vel: FloatArray,
    heading: float,
) -> None:  # fmt: skip
    """Advance by one sample: rates [rad/s], specific force [m/s2], and the aids, nan where there is none."""
    if aid != AIRSPEED:
        air = math.nan  # an aid that was not asked for is not used at all
    if s.memory[0].started == 0.0 or dt > LONG_GAP_S:
        start(s, c, force, air)
        if heading == heading:
            true_heading(s, c, heading)
        return
    take(s, c, dt, rate, force, air)
    fixed = aid == GNSS and vel[0] == vel[0] and vel[1] == vel[1] and vel[2] == vel[2]
    if s.memory[0].time >= c.update_s - 1e-9 or fixed or heading == heading:
        update(s, c, aid, fixed, vel, heading)


@inlined
def update(s: State, c: Settings, aid: int, fixed: bool, vel: FloatArray, heading: float) -> None:
    """Carry the covariance to now, take in what is measured, and correct the state."""
    propagate(s, c)
    s.dx[:] = 0.0
    if aid == GNSS:
        remember(s, c)
    if heading == heading:
        true_heading(s, c, heading)
    resting = rest(s, c, aid != NO_AID)
    if aid == AIRSPEED and s.memory[0].airspeed_rows > 0:
        airspeed(s, c)
    elif fixed:
        velocity_fix(s, c, vel)
    elif (aid == NO_AID or (s.memory[0].velocity_known == 0.0 and math.isnan(s.memory[0].speed))) and not resting:
        for i in range(3):
            level_velocity(s, c, i, 0.0, c.speed_noise**2 / s.memory[0].time)
    correct(s)
    s.sums[:] = 0.0
    s.flat[:SINCE_UPDATE] = 0.0


@kernel
def filter_log(
    s: State, c: Settings, aid: int, dt: FloatArray, rate: FloatArray, force: FloatArray, air: FloatArray,
    vel: FloatArray, heading: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Run `advance` over a log: the down vector and its sigma [rad] of every row into ``out`` (n, 4)."""
    for i in range(len(dt)):
        advance(s, c, aid, dt[i], rate[i], force[i], air[i], vel[i], heading[i])
        out[i, 0], out[i, 1], out[i, 2] = s.C_nb[2, 0], s.C_nb[2, 1], s.C_nb[2, 2]
        out[i, 3] = math.sqrt(s.P[0, 0] + s.P[1, 1])
