"""Roll and pitch errors of the station compared with vqf, imufusion and ahrs, all in one run.

Logs with truth are recorded; the paper's flight and simulated vehicles are drawn. Peers are the extra `peers`, at
their defaults, in the same axes and from the same first sample.
"""

from collections.abc import Callable

import imufusion
import numpy as np
from ahrs.filters import Madgwick, Mahony
from vqf import VQF

from procedures.arrays import BoolArray, FloatArray
from procedures.attitude.attitude_estimate import estimate, estimate_both_directions
from procedures.attitude.attitude_log import AttitudeLog, inclination, roll_pitch_of
from procedures.units import STANDARD_GRAVITY
from station.attitude.attitude_log import read_log
from tests.drivers.simulated.flight import LEVEL_S, paper_flight
from tests.drivers.simulated.vehicles import FOG, MEMS, VEHICLES, vehicle_log
from tests.paths import DATA
from tests.proof.evidence import Figure

AFTER_S = 60.0  # aided logs count from here
AIDS = ("airspeed-filter", "gnss", "airspeed", "none")


def up_to_down(quaternion: FloatArray) -> FloatArray:
    """Return down vectors (n, 3) of quaternions (n, 4), scalar first, that take the body to a frame with z up."""
    w, x, y, z = quaternion.T
    return -np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)


def by_vqf(log: AttitudeLog) -> FloatArray:
    return up_to_down(VQF(log.nominal).updateBatch(log.omega_b, log.f_b)["quat6D"])


def by_imufusion(log: AttitudeLog) -> FloatArray:
    filter_ = imufusion.Ahrs()
    rate, force = np.degrees(log.omega_b), log.f_b / STANDARD_GRAVITY
    out = np.empty((len(log.t), 4))
    for i, dt in enumerate(log.intervals):
        filter_.set_sample_period(dt)
        filter_.update_no_magnetometer(rate[i], force[i])
        out[i] = filter_.get_quaternion()
    return up_to_down(out)


def by_ahrs(kind: type) -> Callable[[AttitudeLog], FloatArray]:
    def run(log: AttitudeLog) -> FloatArray:
        down = -log.f_b[0] / np.linalg.norm(log.f_b[0])
        start = np.array([1 - down[2], -down[1], down[0], 0.0])  # the shortest turn that puts -down on z
        start = start / np.linalg.norm(start) if down[2] < 0.999999 else np.array([0.0, 1.0, 0.0, 0.0])
        return up_to_down(kind(gyr=log.omega_b, acc=log.f_b, frequency=1 / log.nominal, q0=start).Q)

    return run


PEERS: dict[str, Callable[[AttitudeLog], FloatArray]] = {
    "vqf": by_vqf, "imufusion": by_imufusion, "ahrs Madgwick": by_ahrs(Madgwick), "ahrs Mahony": by_ahrs(Mahony),
}  # fmt: skip


def counted(log: AttitudeLog, after: float = -np.inf) -> BoolArray:
    """Return the rows that count: scored, with truth, after a time."""
    truth = log.true_down
    rows = np.isfinite(truth).all(axis=1) & (log.t > after)
    return rows if log.scored is None else rows & log.scored


def rms_deg(log: AttitudeLog, down: FloatArray, after: float = -np.inf) -> float:
    """Return the rms inclination error over the rows that count."""
    rows, truth = counted(log, after), log.true_down
    return float(np.degrees(np.sqrt(np.mean(inclination(down[rows], truth[rows]) ** 2))))


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return errors on the logs and on ``size`` simulated drives and flights each."""
    logs = {path.stem: read_log(path) for path in sorted((DATA / "attitude").glob("*.csv"))}
    aided = [log for log in logs.values() if log.airspeed is not None]
    free = [log for log in logs.values() if log.airspeed is None]
    own: dict[str, Callable[[AttitudeLog], FloatArray]] = {
        "station": lambda log: estimate(log, "none").down,
        "station, both directions": lambda log: estimate_both_directions(log, "none").down,
    }
    result = dict[str, Figure]()
    for name, run in (own | PEERS).items():
        limit = {"station": 0.50, "station, both directions": 0.44}.get(name)
        error = np.mean([rms_deg(log, run(log)) for log in free])
        result[f"recorded motion without aid, {name}"] = Figure(error, "deg rms", at_most=limit)
    for aid in AIDS:
        error = np.mean([rms_deg(log, estimate(log, aid).down, AFTER_S) for log in aided])
        result[f"recorded flights and drives, station by {aid}"] = Figure(error, "deg rms")
    for name, run in PEERS.items():
        error = np.mean([rms_deg(log, run(log), AFTER_S) for log in aided])
        result[f"recorded flights and drives, {name}"] = Figure(error, "deg rms")
    return result | vehicles(size, seed) | flight(size, seed)


def vehicles(size: int, seed: int) -> dict[str, Figure]:
    """Return errors without aid on simulated vehicles, next to VQF's, and the error over the stated sigma."""
    result = dict[str, Figure]()
    for kind in VEHICLES:
        for grade, sensors in (("MEMS", MEMS), ("FOG", FOG)):
            drives = [vehicle_log(kind, 100 + seed + number, sensors) for number in range(size)]
            tracks = [estimate(log, "none") for log in drives]
            error, vqf = (
                np.mean([rms_deg(log, down) for log, down in zip(drives, downs, strict=True)])
                for downs in ([track.down for track in tracks], [by_vqf(log) for log in drives])
            )
            z2 = [np.mean((inclination(t.down, log.true_down) / t.sigma)[counted(log)] ** 2)
                  for log, t in zip(drives, tracks, strict=True)]  # fmt: skip
            title = f"simulated {kind}, {grade}"
            result[f"{title}: station"] = Figure(error, "deg rms")
            result[f"{title}: vqf"] = Figure(vqf, "deg rms")
            result[f"{title}: error over sigma"] = Figure(np.sqrt(np.mean(z2)), at_least=0.5, at_most=1.7)
    return result


def flight(size: int, seed: int) -> dict[str, Figure]:
    """Return the largest errors in the turn of the paper's flight: 200 m/s, angle of attack 3 deg."""
    logs, result = [paper_flight(seed + number) for number in range(size)], dict[str, Figure]()
    for aid, what, limit in (("airspeed-filter", "largest error in the turn, mean", 0.35),
                             ("paper-filter", "by the paper's filter", None)):  # fmt: skip
        mean = np.mean([turn_maximum(log, estimate(log, aid).down) for log in logs], axis=0)
        for angle, each in zip(("roll", "pitch"), mean, strict=True):
            result[f"the paper's flight, {angle}: {what}"] = Figure(each, "deg", at_most=limit)
    return result


def turn_maximum(log: AttitudeLog, down: FloatArray) -> FloatArray:
    """Return the largest roll and pitch errors (2,) [deg] in the turn."""
    errors = np.array(roll_pitch_of(down)) - np.array([log.roll, log.pitch])
    return np.degrees(np.abs(errors[:, log.t > LEVEL_S]).max(axis=1))
