"""Which effects a campaign can speak of at all: those that something in it excites.

An effect may have acted in several ways (in one dwell or another, with one time constant or another). Slab and
faces without certificate are part of the model from the start: to ask whether they are there is to ask what the
model would lose without them, so their columns are taken out of it and put to the test.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.effects.effect import Effect
from procedures.effects.excitation import Columns
from procedures.errors import DoesNotFit, ProcedureError
from procedures.evidence.linear_model import LinearFit, Term, fit_linear
from procedures.evidence.residual_rows import Evidence
from procedures.statistics.significance import STD_PER_MAD
from procedures.twelve_positions.bench_parameters import BenchParameters, tilt_names
from procedures.units import DEG_H_PER_DEG_S, PPM_PER_ONE, UG_PER_G

# g, deg/s: 1 sigma of a dwell of the grade the ranges are for
NAVIGATION_GRADE_STD = (1 / UG_PER_G, 0.5 / DEG_H_PER_DEG_S)
ROUNDING = 1e-9  # of a column's largest
TIMES_SPREAD = 2.0  # by which an effect may be larger than what makes the spread of soaks' levels


def grade_factor(evidence: Evidence, effect: Effect) -> float:
    """Return by how much an effect's plausible range is wider than for a unit of navigation grade; at least 1.

    Nonlinearity, temperature coefficients and the care of the hands go with the noise, over many decades. Of a
    unit that is known by a rest alone how far its output drifts determines its grade too, for what goes with a
    channel that is measured: the biases of MEMS sensors move with temperature by tens of times their noise over
    100 s.
    """
    return noise_in_navigation_grade(evidence, _triad_of(effect), _is_measured(effect))


def as_it_drifts(evidence: Evidence, effect: Effect, H: FloatArray) -> FloatArray:
    """Return coefficients (k,) of columns H (n, k) that move rests as far as they drift; else zero.

    Of a unit that is known by rests alone, what goes by time may be all that is seen: a MEMS gyroscope jumps and
    drifts by tens of times its noise. Whether it is a random walk is asked of every drift and jump that is found.
    What goes by time or with a channel may make all of the spread of several rests.
    """
    of_triad, found = evidence.triad == _triad_of(effect), np.zeros(H.shape[1])
    is_by_time = effect.driver == "time"
    if (evidence.rows("mean", "norm", "rate") & of_triad).any() or not (is_by_time or _is_measured(effect)):
        return found
    least = ROUNDING * float(np.max(np.abs(H), initial=0.0))
    if effect.is_scatter:  # its draws together
        rows = of_triad & evidence.rows("soak", "level") & np.any(H != 0, axis=1)
        spread = np.sqrt(np.mean(np.sum(H[rows] ** 2, axis=1))) if rows.any() else 0.0
        return _sizes(evidence, rows, np.full(H.shape[1], spread), least) if rows.any() else found
    if is_by_time and (rows := evidence.rows("soak") & of_triad).any():
        found = _sizes(evidence, rows, H[rows].std(axis=0), least)
    if (rows := evidence.rows("level") & of_triad).any():  # of the sensor that shows most: others are alike
        between = TIMES_SPREAD * _sizes(evidence, rows, np.full(H.shape[1], np.max(H[rows].std(axis=0))), least)
        found = np.maximum(found, between)
    return found


def _sizes(evidence: Evidence, rows: BoolArray, moved: FloatArray, least: float) -> FloatArray:
    """Return the coefficients (k,) that move rows by their rms, where 1 of each moves them by ``moved`` (k,).

    What moves them by no more than ``least`` is zero but for rounding, as a turn about the vertical is.
    """
    drift = float(np.sqrt(np.mean(evidence.residual[rows] ** 2)))
    found: FloatArray = np.divide(drift, moved, out=np.zeros(len(moved)), where=moved > least)
    return found


def _triad_of(effect: Effect) -> int:
    return int(effect.name.startswith("gyroscope"))


def _is_measured(effect: Effect) -> bool:
    return effect.driver in {"temperature", "channel"}


@lru_cache(maxsize=32)
def noise_in_navigation_grade(evidence: Evidence, triad: int, is_measured: bool) -> float:
    """Return how many times as noisy as of navigation grade a triad is, by `grade_factor`; at least 1."""
    of_triad = evidence.triad == triad
    rows = evidence.rows("mean", "norm", "rate") & of_triad
    if rows.any():
        return max(float(np.median(evidence.sigma[rows])) / NAVIGATION_GRADE_STD[triad], 1.0)
    if not (rows := evidence.rows("soak") & of_triad).any():
        return 1.0
    if not is_measured:
        return max(float(np.median(evidence.sigma[rows])) / NAVIGATION_GRADE_STD[triad], 1.0)
    sensors = [evidence.residual[rows & (evidence.axis == axis)] for axis in np.unique(evidence.axis[rows])]
    drift = max(STD_PER_MAD * float(np.median(np.abs(of))) for of in sensors)  # of the one that moves most
    return max(max(float(np.median(evidence.sigma[rows])), drift) / NAVIGATION_GRADE_STD[triad], 1.0)


SAME, TINY = 1e-9, 1e-300
MAX_STD_IN_PLAUSIBLE = 0.1  # of a coefficient's plausible size that one sigma of it must at least come down to


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One way in which an effect may have acted: its columns, its rows H (n, k), its coefficients' range (k,).

    ``taken`` (p,) marks the model's own columns that it is, all False where it adds to the model. One that is
    ``tied`` would go beyond what the model holds already at its prior: faces, and gravity as it is stated.
    ``is_tried`` is not of a face's tilt on a cube without certificate, whose faces the model holds by pairs, nor
    of a scale factor at one attitude alone, where it is one with the bias. ``log_volume`` is ln of what the data
    leave of a time constant, as a share of the distance between its neighbours on a grid.
    """

    effect: Effect
    columns: Columns
    term: Term
    taken: BoolArray
    tied: bool = False
    is_tried: bool = True
    log_volume: float = 0.0

    @property
    def is_of_model(self) -> bool:
        """Say whether the model holds it from the start."""
        return bool(self.taken.any())

    def evidence(self, evidence: Evidence) -> Evidence:
        """Return the evidence with what the model says of it put back to zero."""
        if not self.is_of_model:
            return evidence
        return replace(evidence, residual=evidence.residual - evidence.A[:, self.taken] @ evidence.x[self.taken])

    def fit(
        self,
        evidence: Evidence,
        others: Sequence[Term] = (),
        factor: FloatArray | None = None,
    ) -> LinearFit:
        """Fit it with the model and other terms; it stands last. ``factor`` (n,) widens the rows' sigma."""
        return fit_linear(self.evidence(evidence), [*others, self.term], ~self.taken, factor)

    def without(
        self, evidence: Evidence, others: Sequence[Term] = (), factor: FloatArray | None = None
    ) -> LinearFit:
        """Fit the model and other terms without it; ``factor`` (n,), dimensionless, widens the rows' sigma."""
        return fit_linear(self.evidence(evidence), others, ~self.taken, factor)


class Candidates(Mapping[str, Sequence[Candidate]]):
    """By effect, in catalogue order, every way in which it may have acted and would show.

    An effect's are made when they are first asked for: where a loop only tries a name, it asks for few.
    """

    def __init__(self, evidence: Evidence, fits: CampaignFits, effects: Sequence[Effect]) -> None:
        self._evidence = evidence
        self._of_model = _of_model(fits, len(evidence.x))
        self._effects = {effect.name: effect for effect in effects}
        self._made = dict[str, Sequence[Candidate]]()
        self._is_solved = fits.accelerometer is not None or fits.gyroscope is not None
        self._same = dict[str, list[str]]()

    def __getitem__(self, name: str) -> Sequence[Candidate]:
        if not (ways := self._ways(name)):
            raise KeyError(name)
        return ways

    def __iter__(self) -> Iterator[str]:
        return (name for name in self._effects if self._ways(name))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _ways(self, name: str) -> Sequence[Candidate]:
        if name not in self._effects:
            return ()
        if name not in self._made:
            effect = self._effects[name]
            ways, before = list(_ways(self._evidence, effect, self._of_model)), effect.same_at_rest
            if ways and _are_the_same(ways, self._ways(before)):
                self._same.setdefault(before, []).append(name)
                # a calibration carries it to other attitudes, where the two differ; alone it is the output here
                ways = [replace(each, is_tried=False) for each in ways] if self._is_solved else []
            self._made[name] = ways
        return self._made[name]

    def same_as(self, candidate: Candidate) -> tuple[str, ...]:
        """Return the effects that are no hypotheses of their own, since their columns are this one's here."""
        return () if self._is_solved else tuple(self._same.get(candidate.effect.name, ()))


def _are_the_same(ways: Sequence[Candidate], before: Sequence[Candidate]) -> bool:
    """Say whether ways have another effect's columns, sensor by sensor, as at one attitude alone."""
    if not before or ways[0].columns.coefficients != before[0].columns.coefficients:
        return False
    one, other = (
        each[0].term.H / np.maximum(np.linalg.norm(each[0].term.H, axis=0), TINY) for each in (ways, before)
    )
    return bool(np.min(np.abs(np.sum(one * other, axis=0))) >= 1 - SAME)


def _ways(
    evidence: Evidence, effect: Effect, of_model: Mapping[str, tuple[Columns, IntArray]]
) -> Iterator[Candidate]:
    if effect.name in of_model:
        columns, index = of_model[effect.name]
        taken = np.zeros(len(evidence.x), dtype=bool)
        taken[index] = True
        yield Candidate(effect, columns, Term(-evidence.A[:, taken], np.full(len(index), np.inf)), taken)
        return
    nothing = np.zeros(len(evidence.x), dtype=bool)
    for columns in effect.columns(evidence.excitation):
        term = term_of(evidence, effect, columns)
        H = term.H
        if not np.all(np.isfinite(H)):
            continue
        is_determined = (
            MAX_STD_IN_PLAUSIBLE * term.plausible * np.linalg.norm(H / evidence.sigma[:, None], axis=0) > 1
        )
        if is_determined.any() or effect.is_scatter:
            is_tried = not effect.covered_by or effect.covered_by not in of_model
            bare = replace(
                columns, accel=None, gyro=None, rotation=None
            )  # H has it: made again where a refit needs it
            yield Candidate(effect, bare, term, nothing, effect.is_held_at_prior, is_tried)


def term_of(evidence: Evidence, effect: Effect, columns: Columns) -> Term:
    """Return an effect's columns as they show in the evidence, with their coefficients' ranges for its grade.

    What is not linear, of which a search says nothing yet, is not among them.
    """
    kept = np.array([name not in columns.nonlinear for name in columns.coefficients])
    ranges, H = effect.plausible_of(columns)[kept], evidence.column(columns)[:, kept]
    if effect.is_scatter and effect.kind != "instrument":
        return Term(H, ranges)
    widened = ranges * grade_factor(evidence, effect)
    if (columns.unit or effect.unit) == "ppm":  # of no grade does a scale factor lack more than all of it
        widened = np.minimum(widened, np.maximum(ranges, PPM_PER_ONE))
    widened = np.maximum(widened, as_it_drifts(evidence, effect, H))
    for name, share in columns.side_effects.items():
        i = columns.coefficients.index(name)
        widened[i] = share * np.max(np.delete(widened, i))
    return Term(H, widened)


def _of_model(fits: CampaignFits, width: int) -> dict[str, tuple[Columns, IntArray]]:
    """Return what of slab and faces the model holds, by effect: the coefficients and their columns of A."""
    joint = fits.accelerometer or (fits.gyroscope.joint if fits.gyroscope else None)
    if joint is None or joint.is_turned_freely:
        return {}
    bench: BenchParameters = joint.bench
    several = len(fits.campaigns) > 1
    sides = [
        f"{side}{f'.{i + 1}' if several else ''}" for i in range(len(fits.campaigns)) for side in ("east", "north")
    ]
    found = {"slab.tilt": (Columns(tuple(sides)), 12 + np.arange(len(sides)))}
    names, index = list[str](), list[int]()
    for cube in range(bench.cubes):
        begin = 12 + bench.cube_slice(cube).start
        for i, name in enumerate(tilt_names()):
            if not bench.certified_pairs(cube)[i // 2]:
                names.append(f"{name}{f'.{cube + 1}' if bench.cubes > 1 else ''}")
                index.append(begin + i)
    if names:
        found["fixture.parallelism"] = (Columns(tuple(names)), np.array(index))
    return found


@contextmanager
def raising_does_not_fit(has_effects: bool = True) -> Iterator[None]:
    """Turn what a refit or a test with effects in it runs into to `DoesNotFit`: it says nothing of the data.

    The data were held to their labels, and the model without effects was fitted to them, before any was tried.
    """
    if not has_effects:
        yield
        return
    try:
        with np.errstate(divide="raise", invalid="raise", over="raise"):
            yield
    except DoesNotFit:
        raise
    except (ProcedureError, np.linalg.LinAlgError, FloatingPointError) as error:
        raise DoesNotFit(f"the model with the effect in it cannot be fitted: {error}") from error
