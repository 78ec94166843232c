"""How far a campaign under way is, in words."""

import re

import numpy as np
import pytest

from procedures.planning.campaign_design import CampaignDesign, Placing
from procedures.planning.design_sigmas import NAMES
from procedures.planning.sequential import NextPlacing
from procedures.planning.wanted_sigmas import WantedSigmas
from station.results.planning.continued import apart, continued_text

BIAS = NAMES.index("gyroscope.bias.x")


def asked(sigma: float, others: float = np.inf) -> WantedSigmas:
    wanted = np.full(len(NAMES), others)
    wanted[BIAS] = sigma
    return WantedSigmas(wanted)


def said(now: float, others: float = 1.0) -> str:
    sigmas = np.full(len(NAMES), others)
    sigmas[BIAS] = now
    found = NextPlacing(Placing(1, 30.0), 90.0, sigmas, CampaignDesign((Placing(1, 30.0),)))
    return continued_text(found, asked(2e-5), asked(2e-5, 1.0))


@pytest.mark.parametrize("over", [1.3, 1.01, 1.0001, 1.00003])
def test_a_sigma_that_is_not_met_yet_is_not_said_to_be_the_one_wanted(over: float) -> None:
    now, wanted = apart(0.02 * over, 0.02)
    assert now != wanted
    assert float(now) > float(wanted)
    assert apart(0.0199999, 0.02) == ("0.0200", "0.0200")  # met is met


def test_what_is_not_known_yet_and_what_nobody_limits_is_said_in_words() -> None:
    assert re.match(r"gyroscope bias not yet known, \S+ deg/h wanted\n", said(np.inf, np.inf))
    assert "all else 12.0 of 10.0 usual sigmas\n" in said(1.9e-5, 1.2)
    assert "all else" not in said(1.9e-5, 0.9)
    assert "all else" not in said(2.1e-5, 1.2)  # what is asked for is reason enough
