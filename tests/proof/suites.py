"""Proofs that other packages hold: whole simulated campaigns, and the tests marked as proofs."""

import re
import subprocess
import sys
import tempfile
from functools import partial
from math import erf, sqrt
from pathlib import Path

from tests.paths import ROOT
from tests.proof.evidence import Figure, spread, zero
from tests.year.night import BEYOND, Night, Outcome, one_campaign


def year(size: int, seed: int) -> dict[str, Figure]:
    """Return what ``size`` whole guided campaigns came to, in all that may go wrong at a bench."""
    night = Night()
    for outcome in spread(partial(_campaign, seed), range(size)):
        night.take(outcome)
        if outcome.finding:
            sys.stderr.write(f"{outcome.line}\n")
    result = {
        "findings": zero(len(night.findings)),
        "starts of the program": Figure(night.sessions),
        "kills": Figure(night.kills),
        "values compared with their truth": Figure(night.values),
    }
    for limit in BEYOND:
        chance = night.values * (1 - erf(limit / sqrt(2)))
        result[f"values beyond {limit:g} u"] = Figure(night.beyond[limit])
        result[f"values beyond {limit:g} u, expected by chance"] = Figure(chance)
    return result


def _campaign(seed: int, number: int) -> Outcome:
    with tempfile.TemporaryDirectory(prefix="year-") as folder:
        return one_campaign(Path(folder), seed, number)


def marked(size: int, seed: int) -> dict[str, Figure]:
    """Run the tests that are marked as proofs, in ``size`` processes."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", str(size), "-m", "proof"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    sys.stderr.write(done.stdout[-4000:] if done.returncode not in {0, 5} else "")
    found = {word: int(number) for number, word in re.findall(r"(\d+) (passed|failed|error|skipped)", done.stdout)}
    return {
        "passed": Figure(found.get("passed", 0)),
        "failed": zero(found.get("failed", 0) + found.get("error", 0)),
        "not run: something is missing on the machine": Figure(found.get("skipped", 0)),
    }
