"""From campaigns to a solution: both triads, the bench, the residual, and what stayed open."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench_model import tilt_names
from procedures.campaign import Campaign
from procedures.errors import NotObservable
from procedures.face_check import refuse_wrong_faces
from procedures.frames import AXES
from procedures.hand_turns import GyroscopeFit, solve_gyroscope
from procedures.observations import TriadDwells, dwell_rates, turn_totals
from procedures.residuals import fit_quality, step_residuals
from procedures.solution import Estimate, FitQuality, Solution, TriadCalibration
from procedures.triad import paper_biases, triad_vector
from procedures.twelve_position import JointFit, missing_positions, solve_accelerometer

NEVER_EXCITED = ("accelerometer.cross_product", "accelerometer.cubic (with accelerometer.scale_factor)")
DOUBTFUL = 0.01  # p-value of the global test below which the sigmas are said to be in doubt


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """What was seen and fitted of both triads; None where a triad is absent or not determined."""

    campaigns: tuple[Campaign, ...]
    accel: TriadDwells | None
    gyro: TriadDwells | None
    accelerometer: JointFit | None
    gyroscope: GyroscopeFit | None


def solve(campaigns: Sequence[Campaign]) -> Solution:
    """Solve one unit's campaigns jointly.

    Raises
    ------
    NotObservable
        If neither triad can be solved.
    WrongFace, WrongMounting
        If the accelerometers contradict a dwell's position, or the way the IMU sits in the cube.
    """
    return report(fit(campaigns))


def fit(campaigns: Sequence[Campaign]) -> Fits:
    """Reduce the steps and fit both triads; raises as `solve`."""
    accel, gyro = (dwell_rates(campaigns, triad) for triad in ("accelerometer", "gyroscope"))
    if accel is not None:
        refuse_wrong_faces(accel, [campaign.fixture.C_ib for campaign in campaigns])
    accelerometer = solve_accelerometer(campaigns, accel) if accel is not None else None
    gyroscope = None
    if gyro is not None:
        gyroscope = solve_gyroscope(campaigns, gyro, turn_totals(campaigns, gyro.noise), accelerometer)
    if accelerometer is None and gyroscope is None:
        missing = missing_positions(campaigns, accel or gyro) or ["turns about x, y and z"]
        raise NotObservable("the scale factor and bias of either triad", missing)
    return Fits(tuple(campaigns), accel, gyro, accelerometer, gyroscope)


def report(fits: Fits) -> Solution:
    """Put the fits into one solution."""
    accelerometer, gyroscope, blocks = None, None, []
    counts = fits.campaigns[0].counts
    if fits.accelerometer is not None:
        vector = triad_vector(fits.accelerometer, "accelerometer", fits.accelerometer)
        accelerometer = _with_paper_biases(vector.calibration("count/(g s)" if counts else "output/g"), fits)
        blocks += [(vector.names, vector.covariance)]
    slab, parallelism, bench = _bench(fits.accelerometer)
    blocks += bench
    if fits.gyroscope is not None:
        vector = triad_vector(fits.gyroscope.joint, "gyroscope", fits.accelerometer)
        gyroscope = vector.calibration("count/deg" if counts else "output/(deg/s)")
        blocks += [(vector.names, vector.covariance)]
    quality = fit_quality(fits.accelerometer, fits.gyroscope.joint if fits.gyroscope else None)
    return Solution(
        accelerometer=accelerometer, gyroscope=gyroscope, slab_tilt=slab, parallelism=parallelism,
        quality=quality, names=tuple(name for names, _ in blocks for name in names),
        covariance=_block_diagonal([block for _, block in blocks]),
        reference_temperature=_mean_temperature(fits.campaigns),
        residuals=step_residuals(fits.accelerometer, fits.gyroscope),
        not_observable=_not_observable(fits), warnings=_warnings(fits, quality), unused_steps=_unused(fits),
    )  # fmt: skip


def _with_paper_biases(calibration: TriadCalibration, fits: Fits) -> TriadCalibration:
    assert fits.accelerometer is not None
    twelve, two = paper_biases(fits.accelerometer)
    return replace(calibration, bias_12_position=twelve, bias_two_direction=two)


_Block = tuple[tuple[str, ...], FloatArray]


def _bench(accelerometer: JointFit | None) -> tuple[Estimate | None, Estimate | None, list[_Block]]:
    """Slab tilt of the first campaign and parallelism of its cube, as the accelerometers found them."""
    if accelerometer is None:
        return None, None, []
    cube = 12 + accelerometer.bench.cube_slice(accelerometer.bench.placements[0].cube).start
    index = np.array([12, 13, *range(cube, cube + 6)])
    covariance = accelerometer.fit.covariance[np.ix_(index, index)]
    value, std = accelerometer.fit.x[index], np.sqrt(np.diag(covariance))
    names = ("slab.tilt.east", "slab.tilt.north", *(f"fixture.parallelism.{n}" for n in tilt_names()))
    slab = Estimate(value[:2], std[:2], "rad")
    return slab, Estimate(value[2:].reshape(3, 2), std[2:].reshape(3, 2), "rad"), [(names, covariance)]


def _block_diagonal(blocks: Sequence[FloatArray]) -> FloatArray:
    whole = np.zeros((sum(len(b) for b in blocks),) * 2)
    at = 0
    for block in blocks:
        whole[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return whole


def _mean_temperature(campaigns: Sequence[Campaign]) -> float | None:
    values = np.concatenate([d.series.temperature for c in campaigns for d in c.dwells])
    values = values[np.isfinite(values)]
    return float(values.mean()) if len(values) else None


def _not_observable(fits: Fits) -> tuple[str, ...]:
    found = []
    for triad, solved in (("accelerometer", fits.accelerometer), ("gyroscope", fits.gyroscope)):
        if solved is None:
            found += [f"{triad}.{part}" for part in ("scale_factor", "misalignment", "bias")]
    if fits.accelerometer is not None:
        held = [axis for axis, it_is in zip(AXES, fits.accelerometer.bench.held_pairs(0), strict=True) if it_is]
        found += [f"fixture.perpendicularity.{n} (with misalignment)" for n in tilt_names() if n[0] in held]
        if held:
            found.append("accelerometer.quadratic (with accelerometer.bias and fixture.parallelism)")
        found += NEVER_EXCITED
    return tuple(found)


def _warnings(fits: Fits, quality: FitQuality) -> tuple[str, ...]:
    found = []
    if quality.p_value < DOUBTFUL:
        found.append(
            f"the residual is larger than counting noise explains (chi-square {quality.chi2:.4g} at {quality.dof} "
            f"degrees of freedom): the sigmas are too small; run `station diagnose`"
        )
    if fits.accel is not None and fits.accelerometer is None:
        found.append(
            f"accelerometer not solved: missing {', '.join(missing_positions(fits.campaigns, fits.accel))}"
        )
    if fits.gyro is not None and fits.gyroscope is None:
        lacking = [a for a in AXES if not any(t.axis == a for c in fits.campaigns for t in c.turns)]
        what = f"no turn about {', '.join(lacking)}" if lacking else "the turns left do not determine it"
        found.append(f"gyroscope not solved: its scale factor is unknown ({what})")
    if fits.gyroscope is not None:
        found += _turn_warnings(fits.gyroscope)
    return (*found, *_few_counts(fits))


def _turn_warnings(gyroscope: GyroscopeFit) -> list[str]:
    found = [f"{name}: samples were lost while turning; the turn is not used" for name in gyroscope.broken]
    for turn, shape in zip(gyroscope.turns, gyroscope.geometry, strict=True):
        if shape.open_ends:
            taken = np.degrees(shape.closure_std)
            found.append(
                f"{turn.record.name}: less than 2 s of rest at an end; its closure is taken as {taken:.2g} deg"
            )
    return found


def _few_counts(fits: Fits) -> list[str]:
    found = []
    for triad, seen in (("accelerometer", fits.accel), ("gyroscope", fits.gyro)):
        for (_, dwell), row in zip(seen.dwells, seen.estimates, strict=True) if seen else ():
            for axis, estimate in zip(AXES, row, strict=True):
                if estimate.interval is not None:
                    low, high = estimate.interval
                    found.append(
                        f"{dwell.name}: {triad} {axis} shows {estimate.edges} count edges; "
                        f"its rate is only known to lie in [{low:.3g}, {high:.3g}] count/s"
                    )
    return found


def _unused(fits: Fits) -> tuple[str, ...]:
    if fits.gyroscope is None:
        return tuple(turn.name for campaign in fits.campaigns for turn in campaign.turns)
    return fits.gyroscope.broken
