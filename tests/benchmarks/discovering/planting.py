"""A law planted in a simulated unit, and what it does on a campaign's rows; numpy alone, no grammar."""

import itertools
from dataclasses import dataclass, field

import numpy as np

from drivers.simulated.effects import Planted, PlantedEffect, Stimulus, TriadInput
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit_reduced
from procedures.calibration.reduced_steps import reduce_steps
from procedures.campaign.campaign import Campaign
from procedures.effects.excitation import Columns, Excitation
from procedures.evidence.linear_model import fit_linear
from procedures.evidence.residual_rows import Evidence, evidence_of
from tests.benchmarks.discovering.laws import Law, Seen
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, level_axes, truth_of

HEAT_TAU_S = 200.0
LEAST, MOST = 8.0, 20.0  # sigmas of what a law does, all rows together
AHEAD_S = 1.0


@dataclass
class Memory:
    """The specific force of the step before, and the warmth that turning left."""

    now: np.ndarray = field(default_factory=lambda: np.zeros(3))
    before: np.ndarray | None = None
    last_s: float = -np.inf
    heat: float = 0.0

    def of(self, seen: Stimulus) -> tuple[np.ndarray, np.ndarray]:
        """Return f before (1, 3) and the warmth (n, 1) of one stretch of samples."""
        t, here = seen.t[:, 0], seen.f[-1]
        if t[0] > self.last_s + AHEAD_S:
            self.before = seen.f[0] if not np.isfinite(self.last_s) else self.now
        power = np.broadcast_to(np.sum(seen.omega**2, axis=1), t.shape)
        step = float(t[1] - t[0]) if len(t) > 1 else 0.1
        since = t - t[0]
        begin = self.heat * np.exp(-(t[0] - self.last_s) / HEAT_TAU_S) if np.isfinite(self.last_s) else 0.0
        heat = np.exp(-since / HEAT_TAU_S) * (
            begin + np.cumsum(power * np.exp(since / HEAT_TAU_S)) * step / HEAT_TAU_S
        )
        self.now, self.last_s, self.heat = here, float(t[-1]), float(heat[-1])
        return self.before[None], heat[:, None]


def of_stimulus(seen: Stimulus, memory: Memory, enu: np.ndarray) -> Seen:
    """Return what acts on a simulated unit; North and East by the magnetic field ``enu`` (3,) [uT]."""
    n = len(seen.t)
    f, w, B = (np.broadcast_to(v, (n, 3)) for v in (seen.f, seen.omega, seen.magnetic))
    north, east = level_axes(f, B, enu)
    before, heat = memory.of(seen)
    T = np.broadcast_to(seen.temperature, (n, 1)) - 25.0
    rest = np.where(np.isfinite(seen.rest_s), seen.rest_s, 0.0)
    return Seen(f, w, B, T, np.broadcast_to(seen.temperature_rate, (n, 1)), seen.t,
                np.broadcast_to(rest, (n, 1)), np.broadcast_to(before, (n, 3)), north, east, heat)  # fmt: skip


def of_excitation(x: Excitation) -> Seen:
    """Return the same at the nodes of a campaign's rows."""
    campaign = x.per_step("campaign")
    heat, order, kept = np.zeros(len(x.t)), np.lexsort((x.t, campaign)), 0.0
    for before, here in itertools.pairwise(order.tolist()):
        dt = float(x.t[here] - x.t[before])
        kept = 0.0 if campaign[here] != campaign[before] else kept
        power = float(np.sum(x.omega[before] ** 2)) if x.step[here] == x.step[before] else 0.0
        kept = kept * np.exp(-dt / HEAT_TAU_S) + power * -np.expm1(-dt / HEAT_TAU_S)
        heat[here] = kept
    turning = np.array([step.kind == "turn" for step in x.steps])[x.step]
    s = np.where(turning, 0.0, x.rest_s)
    columns = (x.temperature - 25.0, x.temperature_rate, x.t, s)
    return Seen(x.f, x.omega, x.magnetic, *(c[:, None] for c in columns), x.f_before, x.C_sn[:, :, 1],
                x.C_sn[:, :, 0], heat[:, None])  # fmt: skip


@dataclass(frozen=True)
class Drawn:
    """A law with the sensors' signs and shares and phases (3, k) of a seed, of one sensor half the time."""

    law: Law
    along: np.ndarray

    @classmethod
    def of(cls, law: Law, seed: int) -> "Drawn":
        """Draw one."""
        rng = np.random.default_rng([seed, 41])
        along = rng.choice([-1.0, 1.0], 3) * rng.uniform(0.5, 1.0, 3)
        if rng.random() < 0.5:
            along *= np.arange(3) == rng.integers(3)
        phase = rng.uniform(0, 2 * np.pi, 3)
        return cls(law, along[:, None] * np.stack((np.cos(phase), np.sin(phase)), axis=1))

    def values(self, seen: Seen) -> np.ndarray:
        """Return what a size of 1 adds (n, 3) [g, deg/s]."""
        shape = self.law.of(seen)
        if shape.ndim == 2:
            return shape * np.linalg.norm(self.along, axis=1) * np.where(self.along[:, 0] < 0, -1, 1)
        return np.asarray(np.einsum("nik,ik->ni", shape, self.along))

    def planted(self, size: float, enu: np.ndarray) -> Planted:
        """Return it for the simulator."""
        memory = Memory()

        def added(seen: Stimulus, triad: TriadInput, sizes: object) -> np.ndarray:
            return size * self.values(of_stimulus(seen, memory, enu))

        one = {self.law.triad: added}
        effect = PlantedEffect(self.law.name, "", (), accel=one.get("accelerometer"), gyro=one.get("gyroscope"))
        return ((effect, {}),)

    def done(self, evidence: Evidence) -> np.ndarray:
        """Return what a size of 1 does to the rows (n,), in sigmas."""
        value = self.values(of_excitation(evidence.excitation))[:, :, None]
        columns = Columns(("",), accel=value) if self.law.triad == "accelerometer" else Columns(("",), gyro=value)
        return evidence.column(columns)[:, 0] / evidence.sigma


def bare_evidence(campaigns: tuple[Campaign, ...]) -> Evidence:
    """Return a campaign's rows as the model without any effect leaves them."""
    return evidence_of(fit_reduced(reduce_steps(campaigns)))


def size_of(drawn: Drawn, evidence: Evidence, seed: int) -> float:
    """Return a size of 8 to 20 sigmas in addition to all that the model absorbs."""
    fit = fit_linear(evidence, [], factor=np.ones(len(evidence.residual)))
    left = outside_model(fit.Q, drawn.done(evidence))
    return float(np.random.default_rng([seed, 43]).uniform(LEAST, MOST) / np.linalg.norm(left))


def outside_model(Q: np.ndarray, does: np.ndarray) -> np.ndarray:
    """Return what rows (n,) do in addition to the columns of Q."""
    wide = np.zeros(len(Q))
    wide[: len(does)] = does
    return wide - Q @ (Q.T @ wide)


def with_law(law: Law, seed: int) -> tuple[Drawn, Truth, tuple[Campaign, ...]]:
    """Return a law as it is drawn by a seed, the unit that has it, and the unit's campaigns."""
    truth, drawn = truth_of(law.design, seed), Drawn.of(law, seed)
    size = size_of(drawn, bare_evidence(campaigns_of(truth, law.design, seed).campaigns), seed)
    also = drawn.planted(size, np.array(truth.magnetic_enu_ut))
    return drawn, truth, campaigns_of(truth, law.design, seed, also, stated=truth).campaigns
