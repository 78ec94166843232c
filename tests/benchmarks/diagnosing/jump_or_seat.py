"""Print how far a jump of the accelerometers is from the seat most like it.

    python -m tests.benchmarks.diagnosing.jump_or_seat FIRST LAST

A campaign is made with the jump and without it, of one noise: what differs, as far as the model leaves it, is the
jump's doing, in sigmas. What of it no seat of a dwell can do, d, is all that anybody can tell them by: the log
likelihood ratio of two causes of known sizes is normal about +-d^2/2 with variance d^2, so the best test is right
with probability Phi(d/2).
"""

import sys

import numpy as np
from scipy.special import ndtr

from procedures.calibration.joint_calibration import fit
from procedures.diagnosis.candidates import Candidates
from procedures.diagnosis.linear_model import fit_linear
from procedures.diagnosis.residual_rows import Evidence, evidence_of
from procedures.effects import EFFECTS
from tests.benchmarks.diagnosing.designs import DESIGNS, unit
from tests.benchmarks.diagnosing.plants import LEAST, MOST, PLANTS, Sizes, drawn_sizes
from tests.benchmarks.diagnosing.sigmas import Sigmas

NAME = "accelerometer.jump, repeated"
UNSEEN = 1e6  # times its sigma, by which a row says nothing


def _evidence(seed: int, effects: dict[str, Sizes]) -> tuple[Evidence, Candidates]:
    made = DESIGNS[PLANTS[NAME].design]
    fits = fit(made.make(unit(seed, **made.truth, effects=effects), seed, ()))
    evidence = evidence_of(fits)
    return evidence, Candidates(evidence, fits, EFFECTS)


def _keys(evidence: Evidence) -> list[tuple[int, ...]]:
    """Return what each row is of; stated values by their order."""
    order = np.cumsum(~evidence.is_data) * ~evidence.is_data
    each = (evidence.step, evidence.kind, evidence.triad, evidence.axis, order)
    return list(zip(*(values.tolist() for values in each), strict=True))


def apart(seed: int) -> tuple[float, float, float, str]:
    """Return when it jumps [s], what the jump does, what of it no seat can do [sigmas], and the seat's place."""
    plant = PLANTS[NAME]
    sizes = drawn_sizes(NAME, Sigmas({}, plant.sigma), np.random.default_rng([seed, 5]), LEAST, MOST)
    without, pool = _evidence(seed, {})
    with_it, _ = _evidence(seed, {plant.effect: sizes})
    both = {key: row for row, key in enumerate(_keys(with_it))}
    other = np.array([both.get(key, -1) for key in _keys(without)])
    seen = other >= 0  # a dwell in which it jumps has fewer rows
    sigma = np.where(seen, without.sigma, np.inf)
    Q = fit_linear(without, [], factor=np.where(seen, 1.0, UNSEEN)).Q
    wide = np.zeros(len(Q))
    wide[: len(sigma)] = np.where(seen, with_it.residual[other] - without.residual, 0.0) / sigma
    left = wide - Q @ (Q.T @ wide)
    found = []
    for way in pool["placement.dwell"]:
        S = np.zeros((len(Q), way.term.H.shape[1]))
        S[: len(sigma)] = way.term.H / sigma[:, None]
        U, s, _ = np.linalg.svd(S - Q @ (Q.T @ S), full_matrices=False)
        U = U[:, s > 1e-6 * s[0]]
        found.append((float(np.linalg.norm(left - U @ (U.T @ left))), str(way.columns.where)))
    nearest, place = min(found)
    return sizes["after_s"], float(np.linalg.norm(left)), nearest, place


def main() -> None:
    """Print a row per campaign."""
    print("| seed | after s | sigmas | none of a seat's | best test | seat |\n|---|---|---|---|---|---|")
    for seed in range(int(sys.argv[1]), int(sys.argv[2])):
        after, does, d, place = apart(seed)
        print(f"| {seed} | {after:.0f} | {does:.1f} | {d:.1f} | {float(ndtr(d / 2)):.1%} | {place} |", flush=True)


if __name__ == "__main__":
    main()
