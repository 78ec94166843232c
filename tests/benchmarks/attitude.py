"""Print roll and pitch errors and costs of the station beside vqf, imufusion and ahrs, all in one run.

`python -m tests.benchmarks.attitude DATA` with the folder of the attitude logs (broad_*.csv, flight_*.csv,
vehicle_*.csv), or of other `attitude-log/1` files with truth; parts by name: free, held, vehicles, aided, late,
paper, figure5, bench, speed (processor time).
Peers are the extra `peers`, at their defaults, in the same axes and from the same first sample.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import imufusion
import numpy as np
from ahrs.filters import Madgwick, Mahony
from vqf import VQF

from procedures.arrays import BoolArray, FloatArray
from procedures.attitude.attitude_estimate import AttitudeEstimate, estimate
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.both_directions import estimate_both_directions
from procedures.attitude.complementary_filter import ComplementaryFilter
from procedures.attitude.forward_right_down import down_of, inclination, roll_pitch_of
from procedures.attitude.kalman_state import AIDED_SETTINGS, UNAIDED_SETTINGS, KalmanSettings
from procedures.attitude.roll_pitch_kalman_filter import AttitudeKalmanFilter
from procedures.units import STANDARD_GRAVITY
from station.attitude.attitude_log import read_log
from tests.drivers.simulated.flight import FORCE_UG, LEVEL_S, paper_bench, paper_flight
from tests.drivers.simulated.vehicles import FOG, MEMS, VEHICLES, vehicle_log
from tests.paths import DATA

AFTER_S = 60.0  # aided logs count from here
PARTS = ("speed", "bench", "paper", "figure5", "aided", "vehicles", "late", "free", "held")
TABLE_1_FORCE = FORCE_UG * 1e-6 * STANDARD_GRAVITY
WITHIN_95 = 1.73  # sigmas of a direction in two dimensions, inside which 95 % of the errors lie


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
    assert truth is not None
    rows = np.isfinite(truth).all(axis=1) & (log.t > after)
    return rows if log.scored is None else rows & log.scored


def rms_deg(log: AttitudeLog, down: FloatArray, after: float = -np.inf) -> float:
    """Return the rms inclination error over the rows that count."""
    rows, truth = counted(log, after), log.true_down
    assert truth is not None
    return float(np.degrees(np.sqrt(np.mean(inclination(down[rows], truth[rows]) ** 2))))


def honesty(log: AttitudeLog, track: AttitudeEstimate, rows: BoolArray) -> tuple[float, float]:
    """Return the rms of error over sigma (its square is the NEES per axis), and the share within 95 %."""
    truth = log.true_down
    assert truth is not None
    assert track.sigma is not None
    ratio = inclination(track.down[rows], truth[rows]) / track.sigma[rows]
    return float(np.sqrt(np.mean(ratio**2))), float(np.mean(ratio < WITHIN_95))


def smooth(log: AttitudeLog, settings: KalmanSettings | None = None) -> FloatArray:
    """Return the down vectors (n, 3) of ``--direction both`` without aid."""
    return estimate_both_directions(log, "none", settings=settings).down


def print_free(logs: dict[str, AttitudeLog]) -> None:
    """Print the logs without aid: figure 1."""
    ours = {"station, none": lambda log: estimate(log, "none").down, "station, both": smooth}
    print("\ninclination error without aid, deg rms over scored rows (asked: mean <= 0.50, smoothed 0.44)")
    for name, run in (ours | PEERS).items():
        errors = [rms_deg(log, run(log)) for log in logs.values()]
        print(f"  {name:18} mean {np.mean(errors):7.3f}   " + " ".join(f"{e:7.3f}" for e in errors), flush=True)
    print("  " + ", ".join(logs))
    tracks = {name: estimate(log, "none") for name, log in logs.items()}
    for name, moves in (("moving", True), ("at rest", False)):
        found = np.array([
            honesty(log, tracks[name], (log.t > log.t[0] + 5.0) & np.isfinite(log.roll) & (log.scored == moves))
            for name, log in logs.items()
        ])  # fmt: skip
        print(f"  error/sigma {name:8} rms {np.sqrt(np.mean(found[:, 0] ** 2)):.2f}, within 95 % "
              f"{100 * found[:, 1].mean():.0f} %:   " + " ".join(f"{z:7.2f}" for z in found[:, 0]))  # fmt: skip


VARIED = (
    "gyro_noise_per_rate", "gyro_bias_walk", "gyro_bias_std", "gyro_scale_std", "force_noise", "force_bias_std",
    "speed_s", "rest_rate", "rest_force", "rest_s", "rest_velocity_noise", "believed_sigma",
)  # fmt: skip


def print_held(logs: dict[str, AttitudeLog]) -> None:
    """Print what a choice of settings is worth on a trial that had no say: each is halved and doubled."""
    variants: dict[str, KalmanSettings] = {"as it is": UNAIDED_SETTINGS}
    for name in VARIED:
        for factor in (0.5, 2.0):
            variants[f"{name} x {factor:g}"] = UNAIDED_SETTINGS._replace(
                **{name: factor * getattr(UNAIDED_SETTINGS, name)}
            )
    errors = np.array([
        [[rms_deg(log, run(log, s)) for log in logs.values()] for s in variants.values()]
        for run in (lambda log, s: estimate(log, "none", settings=s).down, smooth)
    ])  # fmt: skip
    for title, each in zip(("forwards", "both"), errors, strict=True):
        means = dict(zip(variants, each.mean(axis=1), strict=True))
        low, high = (f(means, key=means.__getitem__) for f in (min, max))
        others = [np.delete(each, i, axis=1).mean(axis=1).argmin() for i in range(len(logs))]
        held = np.mean([each[best, i] for i, best in enumerate(others)])
        print(f"{title}: mean {means['as it is']:.4f}; best {means[low]:.4f} ({low}), worst {means[high]:.4f} "
              f"({high}); each trial by the choice of the other five {held:.4f}")  # fmt: skip
        print("  chosen: " + ", ".join(list(variants)[best] for best in others), flush=True)


def print_vehicles(logs: dict[str, AttitudeLog], seeds: int) -> None:
    """Print vehicles without aid, the logs and simulated ones: error, VQF's, error over sigma."""
    print(f"\nvehicles without aid, deg rms, and error/sigma (asked 0.7 to 1.5); simulated: {seeds} seeds each")
    for name, log in logs.items():
        _print_vehicles(name, [log])
    for kind in VEHICLES:
        for grade, sensors in (("MEMS", MEMS), ("FOG", FOG)):
            _print_vehicles(f"{kind}, {grade}", [vehicle_log(kind, 100 + seed, sensors) for seed in range(seeds)])


def _print_vehicles(name: str, logs: list[AttitudeLog]) -> None:
    tracks = [estimate(log, "none") for log in logs]
    pairs = list(zip(logs, tracks, strict=True))
    error, vqf = (np.mean([rms_deg(*each) for each in them]) for them in (
        [(log, track.down) for log, track in pairs], [(log, by_vqf(log)) for log in logs]))  # fmt: skip
    z = np.array([honesty(log, track, counted(log)) for log, track in pairs])
    ratios = " ".join(f"{each:.2f}" for each in z[:, 0])
    print(f"  {name:36} {error:6.2f}   vqf {vqf:6.2f}   error/sigma {np.sqrt(np.mean(z[:, 0] ** 2)):5.2f}, "
          f"within 95 % {100 * z[:, 1].mean():3.0f} %   each {ratios}", flush=True)  # fmt: skip


def print_late(logs: dict[str, AttitudeLog]) -> None:
    """Print what fixes that come late cost, and what is left where their latency is told."""
    print(f"\nGNSS fixes that are late, deg rms after {AFTER_S:.0f} s: latency not told, told 0.05 s wrong, told")
    for name, log in logs.items():
        assert log.velocity is not None
        for seconds in (0.1, 0.15, 0.2):
            rows = round(seconds / log.nominal)
            velocity = np.vstack([np.full((rows, 3), np.nan), log.velocity[:-rows]])
            late = replace(log, velocity=velocity)
            told = (0.0, seconds - 0.05, seconds)
            errors = [rms_deg(late, estimate(late, "gnss", fix_latency=s).down, AFTER_S) for s in told]
            print(f"  {name:36} {seconds:.2f} s   " + " ".join(f"{e:8.4f}" for e in errors), flush=True)


def print_aided(logs: dict[str, AttitudeLog]) -> None:
    """Print the logs with a velocity: figure 2."""
    print(f"\ninclination error with aids, deg rms after {AFTER_S:.0f} s (asked: flight 1.2, vehicle 0.03)")
    for aid in (
        "airspeed-filter", "gnss", "airspeed", "paper-airspeed", "paper-airspeed-rate", "paper-gnss",
        "paper-filter", "none",
    ):  # fmt: skip
        errors = [rms_deg(log, estimate(log, aid).down, AFTER_S) for log in logs.values()]
        print(f"  {'station, ' + aid:24} " + " ".join(f"{e:8.4f}" for e in errors), flush=True)
    for aid in ("airspeed-filter", "gnss"):
        errors = [rms_deg(log, estimate_both_directions(log, aid).down, AFTER_S) for log in logs.values()]
        print(f"  {'both, ' + aid:24} " + " ".join(f"{e:8.4f}" for e in errors), flush=True)
    for name, run in PEERS.items():
        errors = [rms_deg(log, run(log), AFTER_S) for log in logs.values()]
        print(f"  {name:24} " + " ".join(f"{e:8.4f}" for e in errors), flush=True)
    print("  " + ", ".join(logs))


def print_paper(seeds: int) -> None:
    """Print the paper's flight: figure 3."""
    print(f"\nP2's flight, 200 m/s, angle of attack 3 deg, {seeds} seeds: largest error in the turn, deg")
    print("  (asked of airspeed-filter: mean <= 0.35, worst <= 0.6)")
    for turn_s in (50.0, 300.0, 900.0):
        logs = [paper_flight(seed, turn_s) for seed in range(seeds)]
        for aid in ("airspeed-filter", "airspeed", "paper-airspeed", "paper-airspeed-rate", "paper-filter"):
            worst = np.array([turn_maximum(log, estimate(log, aid).down) for log in logs])
            mean, most = worst.mean(axis=0), worst.max(axis=0)
            print(
                f"  {turn_s:4.0f} s {aid:16} roll mean {mean[0]:7.3f} worst {most[0]:7.3f}   "
                f"pitch mean {mean[1]:7.3f} worst {most[1]:7.3f}", flush=True
            )  # fmt: skip


def print_filter_start(seeds: int) -> None:
    """Print what the velocity filter's start does to the paper's figure 5: vertical velocity, first covariance."""
    logs = [paper_flight(seed) for seed in range(seeds)]
    print(f"\npaper-filter, 50 s turn, {seeds} seeds: mean (worst) largest error in the turn, deg; P0 in m2/s2")
    for starts_level in (True, False):
        for variance in (1e-6, 1e-4, 1e-2, 1.0, 10.0, 100.0):
            found = []
            for log in logs:
                law = ComplementaryFilter(
                    aid="paper-filter", velocity_variance=variance, starts_level=starts_level
                )
                found.append(turn_maximum(log, down_of(*law.run(log).T)))
            (roll, pitch), (most_roll, most_pitch) = np.mean(found, axis=0), np.max(found, axis=0)
            begin = "w = u tan(a)" if starts_level else "w = 0"
            print(f"  {begin:12} P0 {variance:6g}   roll {roll:.2f} ({most_roll:.2f})   "
                  f"pitch {pitch:.2f} ({most_pitch:.2f})", flush=True)  # fmt: skip


def turn_maximum(log: AttitudeLog, down: FloatArray) -> tuple[float, float]:
    """Return the largest roll and pitch errors [deg] in the turn."""
    assert log.roll is not None
    assert log.pitch is not None
    roll, pitch = roll_pitch_of(down)
    turn = log.t > LEVEL_S
    return (
        float(np.degrees(np.abs(roll - log.roll)[turn].max())),
        float(np.degrees(np.abs(pitch - log.pitch)[turn].max())),
    )


def print_bench(seeds: int) -> None:
    """Print rest in the twelve positions: figure 5."""
    print(f"\nat rest in each position, errors of table 1, {seeds} seeds: deg rms after 60 s (asked 0.02)")
    ways: dict[str, Callable[[AttitudeLog], AttitudeEstimate]] = {
        "accelerometers unknown": lambda log: estimate(log, "none"),
        "140 ug told": lambda log: estimate(log, "none", force_bias_std=TABLE_1_FORCE),
    }
    for name, run in ways.items():
        found = np.array([[_rest(paper_bench(s, p), run) for s in range(seeds)] for p in range(1, 13)])
        by_position, z = (np.sqrt(np.mean(found[:, :, i] ** 2, axis=1)) for i in (0, 1))
        print(
            f"  {name:22} "
            + " ".join(f"{e:.4f}" for e in by_position)
            + f"   worst unit {found[..., 0].max():.4f}"
        )
        ratios, share = " ".join(f"{e:6.2f}" for e in z), 100 * found[..., 2].mean()
        print(
            f"  {'error/sigma':22} {ratios}   rms {np.sqrt(np.mean(z**2)):.2f}, within 95 % {share:.0f} %",
            flush=True,
        )
    vqf = np.array(
        [[rms_deg(log, by_vqf(log)) for log in (paper_bench(s, p) for s in range(seeds))] for p in (1, 9)]
    )
    print(f"  vqf, positions 1 and 9: {np.sqrt(np.mean(vqf**2)):.4f}, worst unit {vqf.max():.4f}")
    print("  140 ug of bias on each of two level axes are 0.0113 deg: no filter can see them")


def _rest(log: AttitudeLog, run: Callable[[AttitudeLog], AttitudeEstimate]) -> tuple[float, float, float]:
    track = run(log)
    return (rms_deg(log, track.down), *honesty(log, track, counted(log)))


def print_speed() -> None:
    """Print what a sample costs: figure 4."""
    log = paper_flight(0, 1750.0)
    n = len(log.t)
    print(f"\nns a sample, best of 7, {n} samples at 100 Hz (asked: law 100, filter 250 and 1.2 x vqf)")
    runs: dict[str, Callable[[], object]] = {
        "mixing law": lambda: ComplementaryFilter().run(log),
        "joint, none": lambda: AttitudeKalmanFilter("none", UNAIDED_SETTINGS).run(log),
        "joint, airspeed": lambda: AttitudeKalmanFilter("airspeed-filter", AIDED_SETTINGS).run(log),
        "vqf": lambda: VQF(log.nominal).updateBatch(log.omega_b, log.f_b),
    }
    for run in runs.values():
        run()
    best = dict.fromkeys(runs, np.inf)
    for _ in range(7):  # in turn, so that all see the same machine
        for name, run in runs.items():
            start = time.process_time()
            run()
            best[name] = min(best[name], time.process_time() - start)
    for name, seconds in best.items():
        print(f"  {name:18} {1e9 * seconds / n:7.0f}   {seconds / best['vqf']:.2f} x vqf")
    print_online(log)


def print_online(log: AttitudeLog) -> None:
    """Print what one sample costs from Python (asked: 20 us)."""
    assert log.airspeed is not None
    joint, vqf, fusion = AttitudeKalmanFilter("airspeed-filter"), VQF(log.nominal), imufusion.Ahrs()
    rate, force = np.degrees(log.omega_b), log.f_b / STANDARD_GRAVITY
    air = log.airspeed
    steps: dict[str, Callable[[int], object]] = {
        "joint, airspeed": lambda i: joint.step(float(log.t[i]), log.omega_b[i], log.f_b[i], float(air[i])),
        "vqf": lambda i: vqf.update(log.omega_b[i], log.f_b[i]),
        "imufusion": lambda i: fusion.update_no_magnetometer(rate[i], force[i]),
    }
    print("us a sample online")
    for name, step in steps.items():
        for i in range(100):
            step(i)
        start = time.process_time()
        for i in range(100, 20100):
            step(i)
        print(f"  {name:18} {(time.process_time() - start) / 20000 * 1e6:7.2f}")


def main() -> None:
    """Print the parts asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", nargs="?", type=Path, default=DATA / "attitude")
    parser.add_argument("--parts", nargs="*", default=list(PARTS))
    parser.add_argument("--seeds", type=int, default=25)
    options = parser.parse_args()
    logs = {path.stem: read_log(path) for path in sorted(options.data.glob("*.csv"))}
    aided = {name: log for name, log in logs.items() if log.airspeed is not None}
    parts: dict[str, Callable[[], None]] = {
        "speed": print_speed, "bench": lambda: print_bench(max(options.seeds // 5, 2)),
        "paper": lambda: print_paper(options.seeds), "figure5": lambda: print_filter_start(options.seeds),
        "aided": lambda: print_aided(aided),
        "free": lambda: print_free({name: log for name, log in logs.items() if name not in aided}),
        "held": lambda: print_held({name: log for name, log in logs.items() if name not in aided}),
        "vehicles": lambda: print_vehicles(aided, max(options.seeds // 5, 2)),
        "late": lambda: print_late({name: log for name, log in aided.items() if log.nominal < 0.01}),
    }  # fmt: skip
    for part in options.parts:
        parts[part]()


if __name__ == "__main__":
    main()
