"""Print how often what temperature does to a unit is named, and how often it is invented.

`python -m tests.benchmarks.thermal_planted [--count 20] [--first 0] [KIND ...]`: soaks of three hours while it
warms, cools and warms again, alone or after twelve positions and six turns. What is planted is
drawn at 6 to 20 sigmas of what it does beyond straight lines of time and temperature (of which a coefficient of
temperature or a drift is one itself).
"""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np

from drivers.simulated.bench_in_memory import ALL_POSITIONS, SimulatedBench, simulate_campaign
from drivers.simulated.effects import Planted
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, SoakRecord, TurnRecord
from procedures.campaign.plan_steps import Dwell, Step, turn_steps
from procedures.counts.sample_records import CountSeries
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis

THERMAL = {"temperature_rise_k": 10.0, "temperature_tau_s": 1500.0, "temperature_swing_k": 15.0,
           "temperature_swing_period_s": 6500.0}  # fmt: skip
PERIOD_S, SOAK_S, DWELL_S, BLOCK_S = 1.0, 10800.0, 60.0, 100.0
LEAST, MOST = 6.0, 20.0
Sizes = Mapping[str, float]
# effect, coefficient to its first power or its highest, others with it, straight lines it is judged beyond
KINDS: dict[str, tuple[str, str, Sizes, str]] = {
    "bias_temperature": ("bias_temperature", "{}", {}, "t"),
    "bias_temperature order 2": ("bias_temperature", "{}.2", {}, "tT"),
    "bias_temperature order 3": ("bias_temperature", "{}.3", {}, "tTq"),
    "temperature_rate": ("temperature_rate", "{}", {}, "tT"),
    "temperature_lag 120 s": ("temperature_lag", "{}", {"tau_s": 120.0}, "tT"),
    "temperature_lag 400 s": ("temperature_lag", "{}", {"tau_s": 400.0}, "tT"),
    "temperature_lag 1500 s": ("temperature_lag", "{}", {"tau_s": 1500.0}, "tT"),
    "temperature_hysteresis": ("temperature_hysteresis", "{}", {}, "tT"),
    "bias_drift": ("bias_drift", "{}", {}, "T"),
    "nothing": ("", "", {}, ""),
}  # fmt: skip


def unit(seed: int, effects: Mapping[str, Sizes]) -> Truth:
    """Return a unit in a chamber whose temperature goes up, down and up."""
    planted = {name: dict(sizes) for name, sizes in effects.items()}
    return replace(Truth.example(seed), effects=planted, sample_period_s=PERIOD_S, **THERMAL)


def soaked(seed: int, effects: Mapping[str, Sizes], triad: str, *, alone: bool, also: Planted = ()) -> Campaign:
    """Return a soak in the first position, after twelve positions where it is not ``alone``; of one triad.

    Gyroscopes are turned as well. The other triad is left out, which is quicker.
    """
    is_gyro = triad == "gyroscope"
    truth = unit(seed, effects)
    stated = simulate_campaign(truth, seed, dwell_s=DWELL_S, turns=(), positions=(), certificate_sigma=2e-6)
    bench = SimulatedBench(truth, seed, also=also)
    positions = () if alone else ALL_POSITIONS

    def seen(step: Step) -> CountSeries:
        both = bench.perform(step)
        gyro, accel = (both.gyro, None) if is_gyro else (None, both.accel)
        return CountSeries(both.t, gyro, accel, both.temperature, both.period)

    dwells = tuple(DwellRecord(f"dwell_{p:02d}", p, seen(Dwell(p, DWELL_S))) for p in positions)
    turns = tuple(
        TurnRecord(t.name, t.axis, t.direction, t.revolutions, t.start_position, seen(t))
        for t in (turn_steps() if is_gyro and not alone else ())
    )
    nominal = {} if not alone else {
        "accelerometer": float(truth.accel_k.mean()), "gyroscope": float(truth.gyro_k.mean())
    }  # fmt: skip
    soak = SoakRecord("soak", 1, None, seen(Dwell(1, SOAK_S)))
    return replace(stated, dwells=dwells, turns=turns, soaks=(soak,), nominal_scale=nominal)


@cache
def sigma(kind: str, triad: str, axis: str) -> float:
    """Return 1 sigma of a coefficient beyond straight lines, by the simulator and the noise of a block alone."""
    name, key, also, beyond = KINDS[kind]
    quiet = dict.fromkeys(
        ("accel_noise_g", "gyro_arw_deg_rt_s", "accel_instability_g", "gyro_instability_dph"), 0.0
    )
    size = 1e-4 if triad == "accelerometer" else 1.0
    found = []
    for planted in ({}, {f"{triad}.{name}": {key.format(axis): size, **also}}):
        truth = replace(unit(0, planted), **quiet)
        series = SimulatedBench(truth, None).perform(Dwell(1, SOAK_S))
        counts, k = (series.accel, truth.accel_k) if triad == "accelerometer" else (series.gyro, truth.gyro_k)
        found.append(blocks(counts / k / PERIOD_S)["xyz".index(axis)])
        t, T = (blocks(v[:, None])[0] for v in (series.t, series.temperature))
    T = (T - T.mean()) / np.ptp(T)
    lines = {"t": t / t[-1], "T": T, "q": T**2}
    Q, _ = np.linalg.qr(np.column_stack([np.ones(len(t)), *(lines[c] for c in beyond)]))
    change = (found[1] - found[0]) / size
    return float(block_noise(triad) / np.linalg.norm(change - Q @ (Q.T @ change)))


def blocks(values: FloatArray) -> FloatArray:
    """Return the means (k, m) of blocks of samples (n, k), in their unit."""
    n = round(BLOCK_S / PERIOD_S)
    return values[: len(values) // n * n].reshape(-1, n, values.shape[1]).mean(axis=1).T


def block_noise(triad: str) -> float:
    """Return 1 sigma of a block's mean [g, deg/s]."""
    truth = unit(0, {})
    samples = BLOCK_S / PERIOD_S
    if triad == "accelerometer":
        return truth.accel_noise_g / np.sqrt(samples)
    return truth.gyro_arw_deg_rt_s / np.sqrt(BLOCK_S)


def drawn(kind: str, triad: str, seed: int) -> dict[str, dict[str, float]]:
    """Return what the simulator is to plant: one sensor or all three."""
    name, key, also, _ = KINDS[kind]
    if not name:
        return {}
    rng = np.random.default_rng([seed, sum(map(ord, kind))])
    free = (
        list("yz") if triad == "accelerometer" else list("xyz")
    )  # x is up: its bias is one with its scale factor
    axes = free if rng.random() < 0.5 else [str(rng.choice(free))]
    sizes = {
        key.format(axis): float(rng.choice([-1, 1]) * rng.uniform(LEAST, MOST)) * sigma(kind, triad, axis)
        for axis in axes
    }
    return {f"{triad}.{name}": {**sizes, **also}}


def said(found: Diagnosis, truth: Mapping[str, Sizes]) -> str:
    """Return one word for what was said of what was planted."""
    names = {each.effect: each for each in found.findings if each.kind == "instrument"}
    wrong = [n for n, each in names.items() if n not in truth]
    if any(names[n].confidence != "ambiguous" for n in wrong):
        return "WRONG"
    if not truth:
        return "group" if names else "nothing"
    (name,) = truth
    if name not in names:
        in_group = any(name in each.aliases for each in names.values())
        return "behind" if in_group else "other" if names else "missed"
    return "alone" if not wrong and names[name].confidence != "ambiguous" else "led"


def main() -> None:
    """Print a row for each kind and triad."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--bench", action="store_true", help="after the twelve positions")
    parser.add_argument("--verbose", action="store_true")
    parser.add_argument("kinds", nargs="*")
    told = parser.parse_args()
    for kind in told.kinds or KINDS:
        for triad in ("accelerometer", "gyroscope"):
            counted = dict[str, int]()
            for seed in range(told.first, told.first + told.count):
                truth = drawn(kind, triad, seed)
                found = diagnose([soaked(seed, truth, triad, alone=not told.bench)])
                word = said(found, truth)
                counted[word] = counted.get(word, 0) + 1
                if told.verbose:
                    print(seed, word, truth, f"{found.log_p:.1f}", flush=True)
                    for one in found.findings:
                        value = dict(zip(one.coefficients, one.value.round(9).tolist(), strict=True))
                        print("    ", one.effect, one.confidence, one.aliases, value, flush=True)
            print(f"{kind} | {triad} | {counted}", flush=True)


if __name__ == "__main__":
    main()
