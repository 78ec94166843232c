"""What is printed: a row per design or effect, and at the end each figure of the issue, asked and measured."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from procedures.effects import EFFECTS
from tests.benchmarks.diagnosing.plants import PLANTS
from tests.benchmarks.diagnosing.trials import Outcome

HEAD = (
    "| planted | trials | alone | group | missed | wrong | coefficients < 4 sigma | verdicts | CPU s | beside it"
    " | seeds to look at |\n|---|---|---|---|---|---|---|---|---|---|---|"
)
TRIALS, NULLS = 100, 200
INSTRUMENT = ("accelerometer", "gyroscope")
LOST = {"missed", "wrong", "false alarm", "odd"}


def row(outcomes: Sequence[Outcome]) -> str:
    """Return a line of what became of one effect's trials."""
    name, words = outcomes[0].effect, Counter(o.word for o in outcomes)
    is_null, is_outside = name.startswith("none"), name.startswith("outside")
    own = "" if is_null or is_outside else PLANTS[name].effect
    alone = f"right {words['right']}" if is_null else f"unexplained {words['unexplained']}" if is_outside else ""
    wrong = f"{words['false alarm']} claims, {words['odd']} odd" if is_null else str(words["wrong"])
    others = Counter(n for o in outcomes for n in o.named if n.rstrip("?") != own)
    cells = (
        name, len(outcomes), alone or words["right"], words["group"] if own else "", words["missed"], wrong,
        _covered(outcomes), ", ".join(f"{v} {c}" for v, c in Counter(o.verdict for o in outcomes).most_common()),
        f"{np.mean([o.seconds for o in outcomes]):.1f}",
        ", ".join(f"{n} {c}" for n, c in others.most_common(5)), _lost(outcomes),
    )  # fmt: skip
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _covered(outcomes: Sequence[Outcome]) -> str:
    worst = compared(outcomes)
    return f"{np.sum(worst < 4)} of {len(worst)}" if len(worst) else "-"


def compared(outcomes: Sequence[Outcome]) -> np.ndarray:
    """Return the worst error over sigma of every trial whose coefficients compare."""
    return np.array([o.worst for o in outcomes if not np.isnan(o.worst)])


def _lost(outcomes: Sequence[Outcome]) -> str:
    lost = [o for o in outcomes if o.word in LOST or (np.isfinite(o.worst) and o.worst >= 4) or np.isinf(o.worst)]
    return " ".join(f"{o.seed}:{o.word[:1] if o.word in LOST else f'{o.worst:.0f}s'}" for o in lost[:20])


def figures(outcomes: Sequence[Outcome]) -> str:
    """Return the closed loop's figures 1 to 3, asked and measured, each with pass or FAIL."""
    by = dict[str, list[Outcome]]()
    for each in outcomes:
        by.setdefault(each.effect, []).append(each)
    of_plants = {name: by.get(name, []) for name in PLANTS}
    names = _names(of_plants) if any(t and not PLANTS[n].alone for n, t in of_plants.items()) else []
    lines = [*_nulls(by), *names, *_alone(of_plants), *_bench(of_plants), *_outside(by)]
    head = "| figure | asked | measured | |\n|---|---|---|---|"
    return "\n".join([head, *lines])


def _line(what: str, asked: str, measured: str, is_met: bool) -> str:
    return f"| {what} | {asked} | {measured} | {'pass' if is_met else 'FAIL'} |"


def _nulls(by: dict[str, list[Outcome]]) -> list[str]:
    nulls = {name: those for name, those in by.items() if name.startswith("none")}
    if not nulls:
        return []
    every = [o for those in nulls.values() for o in those]
    claims = share(every, "false alarm")
    worst = max(nulls, key=lambda name: share(nulls[name], "false alarm"))
    said = f"{claims:.1%} of {len(every)}; worst {worst[6:]} {share(nulls[worst], 'false alarm'):.1%}"
    return [
        _line("1 an instrument effect claimed of nothing", "<= 3 %", said, claims <= 0.03),
        _line("  campaigns of nothing but a bench", f">= {NULLS}", str(len(every)), len(every) >= NULLS),
        _line("  anything else untrue said of nothing", "-", f"{share(every, 'odd'):.1%}", True),
    ]


def _names(of: dict[str, list[Outcome]]) -> list[str]:
    plain = {name: those for name, those in of.items() if not PLANTS[name].alone}
    absent = sorted({e.name for e in EFFECTS} - {PLANTS[n].effect for n, those in plain.items() if those})
    few = [name for name, those in plain.items() if 0 < len(those) < TRIALS]
    unnamed = {n: share(t, "right", "group") for n, t in plain.items() if t and share(t, "right", "group") < 0.97}
    wrong = {n: share(t, "wrong") for n, t in plain.items() if t and share(t, "wrong") > 0.01}
    off = {n: float(np.mean(compared(t) < 4)) for n, t in plain.items() if len(compared(t))}
    off = {n: value for n, value in off.items() if value < 0.97}
    return [
        _line("2 names of the catalogue tried", str(len(EFFECTS)), f"{len(EFFECTS) - len(absent)}{_of(absent)}",
              not absent),
        _line("  rows of fewer than 100 trials", "0", str(len(few)), not few),
        _line("  named right, alone or in its group", ">= 97 % each", _below(unnamed), not unnamed),
        _line("  wrong name", "<= 1 % each", _below(wrong), not wrong),
        _line("  coefficients within 4 sigma", ">= 97 % each", _below(off), not off),
    ]  # fmt: skip


def _alone(of: dict[str, list[Outcome]]) -> list[str]:
    found = {
        n: float(np.mean([o.is_alone and o.word != "wrong" for o in t]))
        for n, t in of.items() if t and PLANTS[n].alone
    }  # fmt: skip
    if not found:
        return []
    said = ", ".join(f"{n} {value:.0%}" for n, value in found.items())
    return [_line("  alone where the design separates it", ">= 90 % each", said, min(found.values()) >= 0.9)]


def _bench(of: dict[str, list[Outcome]]) -> list[str]:
    """Return how often bench and procedure, and a jump, are named first, and the instrument in their place."""
    found = {n: t for n, t in of.items() if t and (PLANTS[n].between or PLANTS[n].effect.endswith(".jump"))}
    if not found:
        return []
    first = {
        n: np.mean([PLANTS[n].effect in {x.rstrip("?") for x in o.named} for o in t]) for n, t in found.items()
    }
    instead = {n: np.mean([_blames(o, PLANTS[n].effect) for o in t]) for n, t in found.items()}
    said, blamed = (", ".join(f"{n} {v:.0%}" for n, v in each.items()) for each in (first, instead))
    return [
        _line("4 bench, procedure and jumps named first", ">= 95 % each", said, min(first.values()) >= 0.95),
        _line(
            "  an effect of the instrument claimed instead", "<= 1 % each", blamed, max(instead.values()) <= 0.01
        ),
    ]


def _blames(outcome: Outcome, true: str) -> bool:
    """Say whether an effect of the instrument that is not there is claimed for certain."""
    return any(name.startswith(INSTRUMENT) and name[-1] != "?" and name != true for name in outcome.named)


def _outside(by: dict[str, list[Outcome]]) -> list[str]:
    there = {name: those for name, those in by.items() if name.startswith("outside")}
    if not there:
        return []
    honest = {n: share(t, "unexplained") for n, t in there.items()}
    wrong = {n: share(t, "wrong") for n, t in there.items()}
    said = ", ".join(f"{n[9:]} {value:.0%}" for n, value in honest.items())
    blamed = ", ".join(f"{n[9:]} {value:.0%}" for n, value in wrong.items())
    return [
        _line("3 outside the catalogue: unexplained", ">= 95 %", said, min(honest.values()) >= 0.95),
        _line("  and a wrong name", "<= 2 %", blamed, max(wrong.values()) <= 0.02),
    ]


def share(outcomes: Sequence[Outcome], *words: str) -> float:
    """Return the share of trials that came to one of these words."""
    return float(np.mean([o.word in words for o in outcomes]))


def _of(names: Sequence[str]) -> str:
    return f", not {', '.join(names)}" if names else ""


def _below(those: dict[str, float]) -> str:
    return ", ".join(f"{n} {value:.1%}" for n, value in those.items()) or "all"
