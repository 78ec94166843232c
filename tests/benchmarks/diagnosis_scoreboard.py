"""Diagnoses of planted worlds: probabilities held against what was planted.

``python -m tests.benchmarks.diagnosis_scoreboard --seeds 1 --raw FILE`` adds a line to FILE for every world that
is not there yet, and prints the tables of all that are; ``--against`` compares with another program's file.
"""

import argparse
import json
import os
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import beta, binom, binomtest, norm

from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.diagnose import diagnose
from procedures.effects import EFFECTS
from procedures.evidence.linear_model import Term
from procedures.evidence.residual_rows import Evidence
from tests.benchmarks.diagnosing.coefficients import Cause, errors_of
from tests.benchmarks.diagnosing.planted_worlds import APART, HELD_BY_THE_MODEL, World, worlds
from tests.benchmarks.discovering.judged import SAME, similarity
from tests.proof.evidence import Figure, spread, zero

KINDS: dict[str, str] = {each.name: each.kind for each in EFFECTS}
BINS = (0.5, 0.8, 0.95, 0.99, 1.0)


@dataclass(frozen=True)
class Answer:
    """What is said of a world; ``nameless`` is the probability that something without a name acts."""

    causes: tuple[Cause, ...]
    nameless: float
    solution: Solution
    evidence: Evidence


def answer_of(campaigns: Sequence[Campaign]) -> Answer:
    """Return what `diagnose` says, each name with its probability."""
    found, terms = diagnose(campaigns), dict[str, list[Term]]()
    for each in found.added:
        if not each.effect.is_scatter:  # whose columns can do whatever a cause does
            terms.setdefault(each.effect.name, []).append(each.term)
    causes = [
        Cause(f.effect, f.probability, (f.effect, *f.aliases), f.joint or f.probability,
              tuple(terms.get(f.effect, ())), f.coefficients, f.value, f.std, f.unit, f.where, f.shape)
        for f in found.findings
    ]  # fmt: skip
    causes += [
        Cause(name, share, tuple(each.shares), each.joint)
        for each in found.unnamed for name, share in each.shares.items() if name in KINDS
    ]  # fmt: skip
    nameless = 1 - float(np.prod([1 - each.probability * each.joint for each in found.unnamed]))
    return Answer(tuple(causes), nameless, found.solution, found.evidence)


def trial(kind: str, seed: int) -> dict[str, Any]:
    """Return a line on the world of a kind and a seed."""
    line: dict[str, Any] = {"kind": kind, "seed": seed}
    begun, cpu = time.perf_counter(), time.process_time()
    try:
        world = worlds()[kind](seed)
        begun, cpu = time.perf_counter(), time.process_time()
        answer = answer_of(world.campaigns)
    except Exception as error:
        return line | {"error": repr(error)}
    seconds = time.process_time() - cpu
    causes = [c for c in answer.causes if c.effect not in HELD_BY_THE_MODEL]
    alike = _alike(world, answer, causes)
    return line | {
        "group": world.group, "nameless": answer.nameless, "seconds": seconds,
        "wall": time.perf_counter() - begun, "causes": [
            {"name": c.effect, "p": c.probability, "right": is_right, "group": list(c.group),
             "group_p": c.group_probability, "group_right": is_right or bool(set(c.group) & world.right)}
            for c, is_right in zip(causes, alike, strict=True)
        ], "coefficients": _coefficients(world, causes), "calibration": _calibration(world, answer),
    }  # fmt: skip


def _alike(world: World, answer: Answer, causes: Sequence[Cause]) -> list[bool]:
    """Say of each cause whether it is what was planted, or does the same to the rows, alone or with the others."""
    found = [c.effect in world.right for c in causes]
    if world.does is None or all(found):
        return found
    does, sure = world.does(answer.evidence), [t for c in causes if c.probability >= 0.5 for t in c.terms]
    fits = [t for t in sure if len(t.H) == len(does)]
    together = bool(fits) and similarity(answer.evidence, fits, does) >= SAME
    for i, cause in enumerate(causes):
        own = [t for t in cause.terms if len(t.H) == len(does)]
        found[i] = found[i] or (together and cause.probability >= 0.5)
        found[i] = found[i] or (bool(own) and similarity(answer.evidence, own, does) >= SAME)
    return [bool(each) for each in found]


def _coefficients(world: World, causes: Sequence[Cause]) -> list[float]:
    """Return errors over sigma of the coefficients of the planted effect, where it has the name alone."""
    first = [c for c in causes if c.effect in world.right and c.probability >= 0.5 and len(c.value)]
    if world.sizes is None or len(first) != 1:
        return []
    errors = errors_of(first[0], world.sizes, world.truth)
    return [float(e) for e in errors if np.isfinite(e)]


def _calibration(world: World, answer: Answer) -> list[float]:
    """Return errors over sigma of bias and scale factor of both triads."""
    truth, found = world.truth, list[float]()
    for triad, k, d in ((answer.solution.accelerometer, truth.accel_k, truth.accel_d_g),
                        (answer.solution.gyroscope, truth.gyro_k, truth.gyro_d_deg_s * 3600)):  # fmt: skip
        if triad is not None:
            found += ((triad.scale_factor.value - k) / triad.scale_factor.std).tolist()
            found += ((triad.bias.value - d) / triad.bias.std).tolist()
    return found


def interval(count: int, of: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Clopper and Pearson)."""
    low = 0.0 if count == 0 else float(beta.ppf(0.025, count, of - count + 1))
    return low, 1.0 if count == of else float(beta.ppf(0.975, count + 1, of - count))


def is_alone(line: Mapping[str, Any]) -> bool:
    """Say whether the planted cause is named at 0.9 or more and nothing else is at 0.5 or more."""
    sure = [c for c in line["causes"] if c["p"] >= 0.5]
    return bool(sure) and all(c["right"] for c in sure) and sure[0]["p"] >= 0.9


def wrong(line: Mapping[str, Any], p: float, kind: str = "") -> bool:
    """Say whether a cause, of a kind, that was not planted has a probability of p or more."""
    return any(
        c["p"] >= p and not c["right"] and KINDS.get(c["name"], "").startswith(kind) for c in line["causes"]
    )


def is_honest(line: Mapping[str, Any]) -> bool:
    """Say whether what no catalogue holds is nameless, or named by what does the same, with no wrong name."""
    return not wrong(line, 0.9) and (line["nameless"] >= 0.5 or any(c["right"] for c in line["causes"]))


def shares(lines: Sequence[Mapping[str, Any]]) -> dict[str, tuple[Sequence[bool], float, float]]:
    """Return by name the marks of worlds, or of causes, and between which shares theirs is to lie."""
    of = {g: [x for x in lines if x["group"] == g] for g in ("catalogue", "bench", "outside", "null")}
    named = [*of["catalogue"], *of["bench"]]
    first = [max(x["causes"], key=lambda c: c["p"], default=None) for x in named]
    found: dict[str, tuple[Sequence[bool], float, float]] = {
        "catalogue and bench: truth first": ([bool(c and c["right"]) for c in first], 0.0, 1.0),
        "catalogue and bench: truth in first group": ([bool(c and c["group_right"]) for c in first], 0.97, 1.0),
        "catalogue and bench: alone": ([is_alone(x) for x in named], 0.8, 1.0),
        "outside: nameless, or a name that does the same": ([is_honest(x) for x in of["outside"]], 0.97, 1.0),
        "all: a wrong name at 0.9 or more": ([wrong(x, 0.9) for x in lines], 0.0, 0.01),
        "all: a wrong name at 0.99 or more": ([wrong(x, 0.99) for x in lines], 0.0, 0.003),
        "null and bench: an error term of the instrument at 0.9 or more": (
            [wrong(x, 0.9, "instrument") for x in (*of["null"], *of["bench"])], 0.0, 0.003),
    }  # fmt: skip
    causes = [c for x in lines for c in x["causes"]]
    for low, high in pairwise(BINS):
        inside = [c for c in causes if low <= c["p"] < high or high == c["p"] == 1.0]
        if inside:
            mean, n = float(np.mean([c["p"] for c in inside])), len(inside)
            least, most = (float(binom.ppf(p, n, mean)) / n for p in (0.025, 0.975))
            name = f"reliability {low} to {high}, stated {mean:.3f}: true"
            found[name] = [c["right"] for c in inside], least, most
    for what in ("coefficients", "calibration"):
        for group in ("catalogue", "null", "bench"):
            z = np.abs([e for x in of[group] for e in x[what]])
            if len(z):
                found[f"{what}, {group}: within 1.96 u"] = (z < norm.ppf(0.975)).tolist(), 0.93, 0.97
    return found


def numbers(lines: Sequence[Mapping[str, Any]]) -> dict[str, Figure]:
    """Return the numbers that are no share: errors over u, and the time."""
    found = dict[str, Figure]()
    for what in ("coefficients", "calibration"):
        for group in ("catalogue", "null", "bench"):
            z = np.array([e for x in lines if x["group"] == group for e in x[what]])
            if len(z):
                found[f"{what}, {group}: rms of error over u"] = Figure(
                    float(np.sqrt(np.mean(z**2))), at_least=0.9, at_most=1.1
                )
    found["processor time, median"] = Figure(float(np.median([x["seconds"] for x in lines])), "s", at_most=2.5)
    return found


def table(lines: Sequence[Mapping[str, Any]]) -> Iterable[str]:
    """Yield the lines of the tables."""
    for name, (marks, _, _) in shares(lines).items():
        if marks:
            low, high = interval(sum(marks), len(marks))
            count = f"{sum(marks):>4} of {len(marks):<4}"
            yield f"  {name:<66} {count} {100 * low:5.1f} .. {100 * high:5.1f} %"
    for name, figure in numbers(lines).items():
        yield f"  {name:<66} {figure.value:.2f} {figure.unit}"


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return what is said of ``size`` planted worlds, their kinds drawn in turn."""
    kinds = list(worlds())
    order = np.random.default_rng(seed).permutation(len(kinds)).tolist()
    items = [(order[i % len(kinds)], seed + i // len(kinds)) for i in range(size)]
    found = spread(_line, [(kinds[kind], APART * kind + one) for kind, one in items])
    lines = [x for x in found if "error" not in x]
    result = {"worlds that failed": zero(len(found) - len(lines))}
    for name, (marks, low, high) in shares(lines).items():
        if marks:
            most = 100 * high if high < 1 else None
            result[name] = Figure(100 * sum(marks) / len(marks), f"% of {len(marks)}", most, 100 * low or None)
    return result | numbers(lines)


def _line(item: tuple[str, int]) -> dict[str, Any]:
    return trial(*item)


def compared(one: Mapping[Any, Any], other: Mapping[Any, Any]) -> Iterable[str]:
    """Yield by how many worlds the first program is better, and worse, with the p of McNemar's exact test."""
    both = one.keys() & other.keys()
    tests: dict[str, tuple[tuple[str, ...], Callable[[Any], bool]]] = {
        "alone": (("catalogue", "bench"), is_alone), "honest": (("outside",), is_honest),
        "no wrong name at 0.9": (("catalogue", "bench", "outside", "null"), lambda x: not wrong(x, 0.9)),
    }  # fmt: skip
    for name, (groups, good) in tests.items():
        pairs = [(good(one[k]), good(other[k])) for k in both if one[k]["group"] in groups]
        better, worse = sum(a > b for a, b in pairs), sum(a < b for a, b in pairs)
        p = binomtest(better, better + worse).pvalue if better + worse else 1.0
        yield f"  {name:<24} better {better}, worse {worse} of {len(pairs)}; p {p:.3f}"


def read(path: Path) -> dict[tuple[str, int], dict[str, Any]]:
    """Return the lines of a file by kind and seed."""
    lines = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    return {(x["kind"], x["seed"]): x for x in lines}


def main() -> None:
    """Run what the file of raw lines does not hold yet, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", nargs="+", type=int, default=[1])
    parser.add_argument("--kinds", nargs="+", default=[""], help="beginnings of names")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--raw", type=Path, default=Path(tempfile.gettempdir()) / "diagnosis_scoreboard.jsonl")
    parser.add_argument("--against", type=Path, help="raw lines of another program, to compare with")
    parser.add_argument("--again", action="store_true", help="only print")
    args = parser.parse_args()
    held = read(args.raw)
    todo = [
        (kind, seed + APART * i) for seed in args.seeds for i, kind in enumerate(worlds())
        if kind.startswith(tuple(args.kinds)) and (kind, seed + APART * i) not in held
    ]  # fmt: skip
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with ProcessPoolExecutor(args.workers) as pool, args.raw.open("a") as file:
        for future in [] if args.again else [pool.submit(trial, *item) for item in todo]:
            line = future.result()
            held[line["kind"], line["seed"]] = line
            file.write(json.dumps(line) + "\n")
            file.flush()
    good = {key: x for key, x in held.items() if "error" not in x}
    print(f"{len(good)} worlds, {len(held) - len(good)} failed")
    for x in held.values():
        if "error" in x:
            print("  failed:", x["kind"], x["seed"], x["error"])
    print(*(table(list(good.values())) if good else ()), sep="\n")
    if args.against:
        print(*compared(good, {k: x for k, x in read(args.against).items() if "error" not in x}), sep="\n")


if __name__ == "__main__":
    main()
