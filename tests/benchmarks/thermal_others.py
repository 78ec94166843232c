"""Print what is said of what temperature does where the catalogue has but a part of it.

`python -m tests.benchmarks.thermal_others [--count 4] [--first 0] [--alone] [KIND ...]`: the soaks of
`tests.benchmarks.thermal_planted`, alone or after positions and turns, with a sensor that lags behind what
lags, one that lags and differs between warming and cooling, and a hysteresis with a play. Sizes are of 6 to 20
sigmas of what each does beyond straight lines of time and temperature, or ``--sigmas LOW HIGH``. All by numpy
alone.
"""

import argparse
from collections import Counter

import numpy as np

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.effects import Planted, PlantedEffect, Stimulus, TriadInput
from procedures.arrays import FloatArray
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis
from tests.benchmarks.thermal_planted import LEAST, MOST, SOAK_S, block_noise, blocks, soaked, unit

GRID_S, LONGEST_S = 1.0, 16000.0
# What each is right to be called: a part of it that the catalogue has, or nothing
KINDS: dict[str, tuple[str, ...]] = {
    "a lag": ("temperature_lag",),
    "a lag of a lag": (),
    "a lag with hysteresis": ("temperature_lag", "temperature_hysteresis"),
    "a lag with play": ("temperature_lag", "temperature_hysteresis"),
    "play": ("temperature_hysteresis",),
}


def lagging(T: FloatArray, tau_s: float) -> FloatArray:
    """Return what follows a temperature (n,), from the first one on."""
    keep, found = np.exp(-GRID_S / tau_s), np.empty_like(T)
    found[0] = T[0]
    for i in range(1, len(T)):
        found[i] = keep * found[i - 1] + (1 - keep) * (T[i] + T[i - 1]) / 2
    return found


def play(T: FloatArray, width_k: float) -> FloatArray:
    """Return T less what follows it with a play (n,), in widths: from -1 to 1."""
    left, at = np.empty_like(T), T[0]
    for i, now in enumerate(T.tolist()):
        at = left[i] = min(max(at, now - width_k), now + width_k)
    return (T - left) / width_k


def shape(kind: str, T: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return what a kind adds (n,), of any size, for temperatures (n,) [degC] on the grid."""
    tau, second, share, width = (rng.uniform(*ends) for ends in ((150, 900), (0.5, 1), (0.3, 1), (1, 2)))
    sensor = lagging(T, tau)
    of = {
        "a lag": sensor,
        "a lag of a lag": lagging(sensor, second * tau),
        "a lag with hysteresis": sensor / 5 + share * np.sign(np.gradient(T)),
        "a lag with play": sensor / 5 + 2 * share * play(T, width),
        "play": play(T, width),
    }
    return of[kind]


def planted(kind: str, triad: str, seed: int, sigmas: tuple[float, float]) -> Planted:
    """Return a kind's effect of one sensor or of all that are at rest in temperature's way."""
    rng = np.random.default_rng([seed, sum(map(ord, kind))])
    t = np.arange(0.0, LONGEST_S, GRID_S)
    grown = shape(kind, SimulatedBench(unit(seed, {}), None).sensor.temperature(t), rng)
    at, T = np.arange(0.0, SOAK_S), SimulatedBench(unit(seed, {}), None).sensor.temperature(np.arange(0.0, SOAK_S))
    of_soak, warm = (blocks(v[:, None])[0] for v in (np.interp(at, t, grown), T))
    lines = np.column_stack([np.ones(len(warm)), np.arange(len(warm)), warm])
    Q, _ = np.linalg.qr(lines)
    one = block_noise(triad) / np.linalg.norm(of_soak - Q @ (Q.T @ of_soak))
    free = "yz" if triad == "accelerometer" else "xyz"
    axes = free if rng.random() < 0.5 else str(rng.choice(list(free)))
    size = np.array([rng.choice([-1, 1]) * rng.uniform(*sigmas) * one * (a in axes) for a in "xyz"])

    def added(seen: Stimulus, own: TriadInput, sizes: object) -> FloatArray:
        found: FloatArray = size * np.interp(seen.t, t, grown)
        return found

    acts = {"accel" if triad == "accelerometer" else "gyro": added}
    return ((PlantedEffect(kind, "", (), accel=acts.get("accel"), gyro=acts.get("gyro")), {}),)


def said(found: Diagnosis, right: tuple[str, ...]) -> str:
    """Return one word: wrong where a name is sure that is not right, or leaves more; else the verdict."""
    sure = [e.effect for e in found.findings if e.kind == "instrument" and e.confidence != "ambiguous"]
    is_left = found.verdict in {"partly", "unexplained"}
    right = right or (() if is_left else ("temperature_lag",))  # a lag of a lag that no row tells from one
    if any(name.partition(".")[2] not in right for name in sure):
        return "WRONG"
    return "named" if sure and found.verdict in {"established", "likely"} else found.verdict


def main() -> None:
    """Print a row for each kind and triad."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=4)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--alone", action="store_true", help="the soak alone")
    parser.add_argument("--sigmas", type=float, nargs=2, default=(LEAST, MOST))
    parser.add_argument("--verbose", action="store_true")
    parser.add_argument("kinds", nargs="*")
    told = parser.parse_args()
    for kind in told.kinds or KINDS:
        for triad in ("accelerometer", "gyroscope"):
            words = Counter[str]()
            for seed in range(told.first, told.first + told.count):
                effect = planted(kind, triad, seed, tuple(told.sigmas))
                found = diagnose([soaked(seed, {}, triad, alone=told.alone, also=effect)])
                word = said(found, KINDS[kind])
                words[word] += 1
                if told.verbose:
                    print(seed, word, found.verdict, f"{found.log_p:.1f}", flush=True)
                    for one in found.findings:
                        value = dict(zip(one.coefficients, one.value.round(9).tolist(), strict=True))
                        print(
                            "    ", one.effect, one.confidence, one.aliases, value, f"{one.share:.3f}", flush=True
                        )
            print(f"{kind} | {triad} | {', '.join(f'{n} {w}' for w, n in words.most_common())}", flush=True)


if __name__ == "__main__":
    main()
