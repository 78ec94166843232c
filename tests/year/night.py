"""Many campaigns after one another: what each came to, and what all of them say together."""

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import erf, sqrt
from pathlib import Path

from procedures.campaign.plan_steps import Step
from tests.year.campaign import Finding, YearCampaign
from tests.year.invariants import Errors, look

BEYOND = (2.0, 3.0, 4.0)  # sigmas


@dataclass(frozen=True, slots=True)
class Outcome:
    """One campaign: how it ended, what must not have been (empty: nothing), its errors and its log of events."""

    seed: int
    number: int
    ended: str
    finding: str
    errors: Errors
    log: list[str]
    kills: int
    sessions: int
    steps: int  # accepted
    seconds: float

    @property
    def line(self) -> str:
        """The campaign in a line."""
        name, worst = max(self.errors.sigmas.items(), key=lambda one: abs(one[1]), default=("nothing", 0.0))
        reported = (
            f"FINDING {self.finding}; again: --seed {self.seed} --campaign {self.number}" if self.finding else ""
        )
        why = "; ".join(filter(None, (self.errors.excused, self.errors.unreported)))
        excused = f" ({why})" if why else ""
        return (
            f"{self.number:5d} {self.ended:<14} {self.steps:2d} steps {self.sessions} sessions {self.kills} kills "
            f"worst {name} {worst:+.1f} sigma{excused} {self.seconds:.1f} s {reported}"
        ).rstrip()


def one_campaign(
    root: Path, seed: int, number: int, steps: Sequence[Step] = (), *, is_whole: bool = False
) -> Outcome:
    """Run a campaign in an empty folder and look at what it left; of ``steps``, or of the usual plan if whole."""
    began = time.process_time()
    campaign, finding, errors = YearCampaign(root, seed, number, steps, is_whole=is_whole), "", Errors({}, "")
    try:
        campaign.run()
        errors = look(campaign)
    except Finding as found:
        finding = str(found)
    except Exception as error:  # of the harness itself: the night goes on
        finding = f"{type(error).__name__} at the end: {error}"
    tally = campaign.tally
    if not finding and not errors.excused:
        far = {name: round(one, 1) for name, one in errors.sigmas.items() if abs(one) > BEYOND[-1]}
        finding = f"beyond {BEYOND[-1]:g} sigma: {far}" if far else ""
    ended = "unsolved" if tally.unsolved else "" if tally.verdict is None else tally.verdict.word
    return Outcome(
        seed, number, ended or "not ended", finding, errors, campaign.machine.log, tally.kills, tally.sessions,
        len(tally.shown), time.process_time() - began,
    )  # fmt: skip


@dataclass
class Night:
    """What campaigns say together."""

    findings: list[Outcome] = field(default_factory=list)
    ended: Counter[str] = field(default_factory=Counter)
    beyond: Counter[float] = field(default_factory=Counter)
    values: int = 0
    campaigns: int = 0
    kills: int = 0
    sessions: int = 0

    def take(self, outcome: Outcome) -> None:
        """Take one in."""
        self.campaigns += 1
        self.kills += outcome.kills
        self.sessions += outcome.sessions
        self.ended[outcome.ended] += 1
        if outcome.finding:
            self.findings.append(outcome)
        if not outcome.errors.excused:
            self.values += len(outcome.errors.sigmas)
            for limit in BEYOND:
                self.beyond[limit] += sum(abs(one) > limit for one in outcome.errors.sigmas.values())

    def text(self, seconds: float) -> str:
        """Return it in words."""
        lines = [
            f"{self.campaigns} campaigns, {self.sessions} starts of the program, {self.kills} kills, "
            f"{seconds / max(self.campaigns, 1):.1f} s of processor time each",
            ", ".join(f"{count} {name}" for name, count in sorted(self.ended.items())),
            f"{self.values} stored values against their truth:",
        ]
        for limit in BEYOND:
            chance = self.values * (1 - erf(limit / sqrt(2)))
            lines.append(f"  beyond {limit:g} sigma {self.beyond[limit]:5d}, by chance {chance:.1f}")
        lines.append(f"{len(self.findings)} findings")
        lines += [f"  --seed {one.seed} --campaign {one.number}: {one.finding}" for one in self.findings]
        return "\n".join(lines)
