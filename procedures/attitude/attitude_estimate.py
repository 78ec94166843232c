"""Roll and pitch of a whole log by any aid: the table of aids, and one function for all of them.

`estimate_both_directions` is for records, not online: the Kalman filter runs forwards, and backwards from the end;
the mean of the two down vectors, each weighted by its own variance, is the smoothed one (Fraser and Potter 1969).
What the two share, the accelerometers' biases, is not made less by the mean: it stays in sigma.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import wraps
from typing import Concatenate, ParamSpec

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog, down_of, earth_rate_ned
from procedures.attitude.complementary_filter import STEEP_PITCH, ComplementaryFilter
from procedures.attitude.complementary_gains import PAPER_GAINS, ComplementaryGains
from procedures.attitude.complementary_velocity_aids import Observability, observability
from procedures.attitude.kalman.kalman_filter import AID_CODE, AttitudeKalmanFilter
from procedures.attitude.kalman.kalman_settings import AIDED_SETTINGS, UNAIDED_SETTINGS, KalmanSettings
from procedures.attitude.kalman.unaided_motion import heading_at_rest, run_unaided
from procedures.attitude.sensor_noise import (
    at_rest,
    clipping_limits,
    down_over_gaps,
    frozen_rows_warning,
    frozen_stretches,
    gate_of,
    gyro_noise,
    rows_of,
    sigma_over_gaps,
)
from procedures.geodesy import EARTH_RATE
from procedures.units import STANDARD_GRAVITY

AID_COLUMN = {"airspeed": "airspeed", "airspeed-filter": "airspeed", "gnss": "velocity",
              "paper-airspeed": "airspeed", "paper-airspeed-rate": "airspeed", "paper-gnss": "velocity",
              "paper-filter": "airspeed"}  # fmt: skip
AIDS = ("none", *AID_COLUMN)
MAX_FILTERED_TURN_S = 60.0  # the printed velocity filter is not believed beyond
UPSIDE_DOWN_COSINE = 0.5
VEHICLE_WARNING = (
    "moves like a vehicle; without a speed its acceleration looks like a tilt: the attitude relies on the "
    "gyros for minutes, and its uncertainty is large; airspeed_m_s or vn_m_s, ve_m_s, vd_m_s would help"
)
FORCE_BIAS_WALK_RATIO = 5e-3  # 1/sqrt(s): an accelerometer's bias drifts by a third of its 1 sigma in an hour


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeEstimate:
    """Attitude along a log: the down vector (n, 3), its 1 sigma (n,) [rad] where the method has one.

    ``gyro_bias`` (3,) [rad/s] at the end with 1 sigma (None where the method has none), ``force_bias_std`` (3,)
    [m/s2] 1 sigma of the accelerometers' biases there; ``parameters`` as used.
    """

    aid: str
    down: FloatArray
    sigma: FloatArray | None
    gyro_bias: FloatArray
    gyro_bias_std: FloatArray | None
    parameters: Mapping[str, float]
    warnings: tuple[str, ...] = ()
    observability: Observability | None = None
    force_bias_std: FloatArray | None = None


def default_aid(log: AttitudeLog) -> str:
    """Return the aid that a log is best served by: airspeed, else GNSS velocity, else none."""
    if log.airspeed is not None and np.isfinite(log.airspeed).any():
        return "airspeed-filter"
    return "gnss" if log.velocity is not None and np.isfinite(log.velocity).any() else "none"


def takes_gains(aid: str) -> bool:
    """Say whether an aid is a form of the complementary filter; without aid, gains ask for it."""
    return aid not in ("airspeed-filter", "gnss")


P = ParamSpec("P")
Estimator = Callable[Concatenate[AttitudeLog, P], AttitudeEstimate]


def over_frozen_rows(run: Estimator[P]) -> Estimator[P]:
    """Run an estimate of a log without the rows in which its sensors are frozen; these are then filled in."""

    @wraps(run)
    def over_all_rows(log: AttitudeLog, /, *args: P.args, **kwargs: P.kwargs) -> AttitudeEstimate:
        stretches = frozen_stretches(log)
        if not stretches:
            return run(log, *args, **kwargs)
        measured = np.ones(len(log.t), bool)
        for each in stretches:
            measured[each] = False
        track = run(rows_of(log, measured), *args, **kwargs)
        return replace(
            track, down=down_over_gaps(log, measured, track.down),
            sigma=None if track.sigma is None else sigma_over_gaps(log, measured, track.sigma),
            warnings=(frozen_rows_warning(log, stretches), *track.warnings),
        )  # fmt: skip

    return over_all_rows


@over_frozen_rows
def estimate(
    log: AttitudeLog, aid: str, gains: ComplementaryGains | None = None, gravity: float = STANDARD_GRAVITY,
    latitude: float | None = None, settings: KalmanSettings | None = None, gyro_bias_std: float | None = None,
    force_bias_std: float | None = None, fix_latency: float = 0.0, learns_motion: bool = True,
) -> AttitudeEstimate:  # fmt: skip
    """Return roll and pitch along a log.

    Parameters
    ----------
    aid
        One of `AIDS`. "none" is the Kalman filter, or with ``gains`` the complementary filter.
    gravity
        m/s2.
    latitude
        rad; takes the Earth's rate off, its horizontal part once the heading is known. Without it the Earth's
        rate is part of the biases and of their sigma.
    gyro_bias_std
        rad/s, 1 sigma of the gyros' biases where it is known, as after a calibration. With a latitude, and small
        enough, it lets a rest at the start determine the heading.
    force_bias_std
        m/s2, 1 sigma of the accelerometers' biases across gravity where it is known: the floor of sigma.
    fix_latency
        s by which GNSS velocities are older than the rows that they stand at.
    learns_motion
        Whether a log without aid may show how it moves; else ``settings`` hold, come what may.
    settings
        Of the Kalman filter; what depends on the log (interval, noise, ranges) is filled in.
    """
    if aid in AID_CODE and gains is None:
        settings = settings or (UNAIDED_SETTINGS if aid == "none" else AIDED_SETTINGS)
        if gyro_bias_std is not None:
            settings = settings._replace(gyro_bias_std=gyro_bias_std)
        if force_bias_std is not None:
            walk = force_bias_std * FORCE_BIAS_WALK_RATIO
            settings = settings._replace(force_bias_std=force_bias_std, force_bias_walk=walk)
        settings = settings._replace(fix_latency=fix_latency)
        if latitude is not None and log.heading is None:
            log, settings = _with_heading(log, settings, latitude)
        track = _kalman_filtered(log, aid, settings, gravity, latitude, learns_motion)
    else:
        track = _complementary(log, aid, gains or PAPER_GAINS, gravity, gate_of(gyro_noise(log)))
    return replace(track, warnings=(*_warnings_of(log), *track.warnings))


def _kalman_filtered(
    log: AttitudeLog, aid: str, settings: KalmanSettings, gravity: float, latitude: float | None,
    learns_motion: bool,
) -> AttitudeEstimate:  # fmt: skip
    earth = np.zeros(3) if latitude is None else earth_rate_ned(latitude)
    rate_limit, force_limit = clipping_limits(log)
    unknown = EARTH_RATE if latitude is None else 0.0
    if aid == "none":  # with one, rest is that of a vehicle whose engine may run
        settings = at_rest(settings, log)
    settings = settings._replace(
        gravity=gravity, nominal_s=log.nominal,
        earth_north=float(earth[0]), earth_down=float(earth[2]), rate_limit=rate_limit, force_limit=force_limit,
        gyro_bias_std=float(np.hypot(settings.gyro_bias_std, unknown)),
    )  # fmt: skip
    warnings = tuple[str, ...]()
    if aid == "none" and learns_motion:
        kept, out, is_vehicle = run_unaided(log, settings)
        warnings = (VEHICLE_WARNING,) if is_vehicle else ()
    else:
        kept = AttitudeKalmanFilter(aid, settings)
        out = kept.run(log)
    sigma = np.hypot(out[:, 3], stamp_sigma(log, out[:, :3]))
    bias, std = kept.gyro_bias
    finite = {name: value for name, value in kept.settings._asdict().items() if np.isfinite(value)}
    return AttitudeEstimate(
        aid, out[:, :3].copy(), sigma, bias, std, finite, warnings, force_bias_std=kept.force_bias_std
    )


def stamp_sigma(log: AttitudeLog, down: FloatArray) -> FloatArray:
    """Return what the stamps add to sigma (n,) [rad] of ``down`` (n, 3): half of a row's interval."""
    across = log.omega_b - np.sum(log.omega_b * down, axis=1)[:, None] * down
    found: FloatArray = 0.5 * log.nominal * np.linalg.norm(across, axis=1)
    return found


def _with_heading(
    log: AttitudeLog, settings: KalmanSettings, latitude: float
) -> tuple[AttitudeLog, KalmanSettings]:
    """Give a log the heading of the rest that it begins with, if its gyros are good enough to see it."""
    found = heading_at_rest(log, latitude, settings.gyro_bias_std)
    if found is None:
        return log, settings
    heading = np.full(len(log.t), np.nan)
    heading[0], std = found
    return replace(log, heading=heading), settings._replace(heading_std=std)


def _complementary(
    log: AttitudeLog, aid: str, gains: ComplementaryGains, gravity: float, gate: float
) -> AttitudeEstimate:
    parameters = {"k1": gains.k1, "k2": gains.k2, "gravity": gravity} | ({} if aid == "none" else {"gate": gate})
    mixer = ComplementaryFilter(gains, aid, gate, gravity)
    down, warnings, seen = mixer.run(log), list[str](), None
    if mixer.is_printed:
        if steep := int(np.sum(np.abs(down[:, 1]) > STEEP_PITCH)):
            warnings.append(
                f"{steep} rows beyond 80 deg of pitch, where the printed Euler form fails; use another aid"
            )
        down = down_of(down[:, 0], down[:, 1])
    if aid == "paper-filter":
        seen = observability(log, gate)
        if seen.open_s > MAX_FILTERED_TURN_S:
            warnings.append(
                f"turning for {seen.open_s:.0f} s: beyond {MAX_FILTERED_TURN_S:.0f} s the printed velocity filter "
                f"diverges; use airspeed-filter"
            )
    return AttitudeEstimate(aid, down, None, mixer.gyro_bias, None, parameters, tuple(warnings), seen)


def _warnings_of(log: AttitudeLog) -> list[str]:
    found = list[str]()
    first = log.f_b[log.t <= log.t[0] + 1.0].mean(axis=0)
    if first[2] > UPSIDE_DOWN_COSINE * np.linalg.norm(first):
        found.append(
            "starts upside down; if it stood level, say --axes, or --accel-convention gravity if 1 g points down"
        )
    rate_limit, force_limit = clipping_limits(log)
    if rows := int((np.abs(log.omega_b) >= rate_limit).any(axis=1).sum()):
        found.append(
            f"gyroscopes clipped at {np.degrees(rate_limit):.4g} deg/s, {rows} rows: the rate is unknown there"
        )
    if rows := int((np.abs(log.f_b) >= force_limit).any(axis=1).sum()):
        found.append(f"accelerometers clipped at {force_limit:.4g} m/s2, {rows} rows")
    return found


HALF_TURN = np.array([-1.0, -1.0, 1.0])  # about down


def reversed_log(log: AttitudeLog) -> AttitudeLog:
    """Return a log as it would have been recorded with time running backwards; its rows are ends of intervals.

    Row i of the result ends where row n - 1 - i of the log begins. Body and level frame are turned by half a turn
    about down: what flew forwards still does, headings stay, the Earth turns as at the opposite latitude.
    """
    begins = np.concatenate(([log.t[0] - log.nominal], log.t[:-1]))
    return AttitudeLog(
        t=-begins[::-1], omega_b=-HALF_TURN * log.omega_b[::-1], f_b=HALF_TURN * log.f_b[::-1],
        airspeed=None if log.airspeed is None else log.airspeed[::-1].copy(),  # a mean over the interval
        velocity=None if log.velocity is None else -HALF_TURN * _at_ends(log.velocity),
        heading=None if log.heading is None else _at_ends(log.heading),
    )  # fmt: skip


def estimate_both_directions(
    log: AttitudeLog, aid: str, gravity: float = STANDARD_GRAVITY, latitude: float | None = None,
    settings: KalmanSettings | None = None, gyro_bias_std: float | None = None,
    force_bias_std: float | None = None, fix_latency: float = 0.0,
) -> AttitudeEstimate:  # fmt: skip
    """Return roll and pitch along a log by one of the Kalman filter's aids, forwards and backwards.

    Arguments are those of `estimate`; the gyro bias is that of the end.
    """
    given = {"settings": settings, "gyro_bias_std": gyro_bias_std, "force_bias_std": force_bias_std}
    ahead = estimate(log, aid, None, gravity, latitude, fix_latency=fix_latency, **given)  # type: ignore[arg-type]
    back = estimate(
        reversed_log(_fixes_in_time(log, fix_latency)), aid, None, gravity,
        None if latitude is None else -latitude, **given,  # type: ignore[arg-type]
    )  # fmt: skip
    assert ahead.sigma is not None
    assert back.sigma is not None
    later, sigma = ahead.down.copy(), ahead.sigma.copy()
    later[:-1] = HALF_TURN * back.down[::-1][1:]  # the state where the next row begins
    sigma[:-1] = back.sigma[::-1][1:]
    assert ahead.force_bias_std is not None
    bias = np.sqrt(2.0 * np.mean(ahead.force_bias_std**2))  # of two axes
    shared = np.hypot(bias / gravity, stamp_sigma(log, ahead.down))
    down, sigma = _mean(ahead.down, ahead.sigma, later, sigma, shared)
    return replace(ahead, down=down, sigma=sigma)


def _mean(
    a: FloatArray, a_sigma: FloatArray, b: FloatArray, b_sigma: FloatArray, shared: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the weighted mean of two directions (n, 3) and its sigma; ``shared`` (n,) [rad] is one error."""
    weight = a_sigma**-2, b_sigma**-2
    mean = weight[0][:, None] * a + weight[1][:, None] * b
    common = np.minimum(shared, np.minimum(a_sigma, b_sigma)) ** 2
    own = (weight[0] ** 2 * (a_sigma**2 - common) + weight[1] ** 2 * (b_sigma**2 - common)) / sum(weight) ** 2
    return mean / np.linalg.norm(mean, axis=1)[:, None], np.sqrt(own + common)


def _at_ends(values: FloatArray) -> FloatArray:
    """Return what stands at rows' ends in reverse: the end of a row is where the next begins."""
    found: FloatArray = np.full_like(values, np.nan)
    found[:-1] = values[-2::-1]
    return found


def _fixes_in_time(log: AttitudeLog, latency: float) -> AttitudeLog:
    """Put velocities at the rows nearest to their own moments, ``latency`` [s] before those they stand at."""
    if log.velocity is None or latency == 0.0:
        return log
    fixed = np.flatnonzero(np.isfinite(log.velocity).all(axis=1) & (log.t - latency >= log.t[0]))
    rows = np.searchsorted(log.t, log.t[fixed] - latency - 0.5 * log.nominal)
    velocity = np.full_like(log.velocity, np.nan)
    velocity[rows] = log.velocity[fixed]
    return replace(log, velocity=velocity)


def compile_all() -> None:
    """Compile the kernels, at the install rather than at the first log: run every aid over two seconds of rest."""
    t, still = 0.01 * np.arange(200.0), np.zeros((200, 3))
    log = AttitudeLog(np.asarray(t, np.float64), still, still - [0.0, 0.0, 9.8], still[:, 0].copy(), still.copy())
    for aid in AIDS:
        estimate(log, aid)
    estimate(log, "none", PAPER_GAINS)
    for aid in AID_CODE:
        kept = AttitudeKalmanFilter(aid)
        kept.step(0.0, log.omega_b[0], log.f_b[0])
        kept.step(0.01, log.omega_b[1], log.f_b[1])


if __name__ == "__main__":
    compile_all()
