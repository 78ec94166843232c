"""Which dwells of solved campaigns stood turned against the marks, in words."""

from collections.abc import Sequence

import numpy as np

from procedures.bench.heading_errors import heading_error_text, heading_errors
from procedures.campaign.campaign import Campaign
from procedures.dwells_and_turns.twelve_position import TriadFit
from procedures.earth.gyrocompass import CertainDwell

SOLVED = (1e-3, 1e-3)  # 1 sigma, relative, of K as turns and dwells tell it, with what a bad heading does to it


def turned_off(campaigns: Sequence[Campaign], joint: TriadFit) -> tuple[list[str], list[str]]:
    """Return the dwells that stood turned against the marks, campaign by campaign: each in words; sure names."""
    K, said, sure = np.degrees(joint.fit.x[:9].reshape(3, 3)), list[str](), list[str]()
    for number, campaign in enumerate(campaigns):
        rows = [i for i, (of, _) in enumerate(joint.seen.dwells) if of == number]
        records = [joint.seen.dwells[i][1] for i in rows]
        known = [
            CertainDwell(record.position, joint.seen.rate[i], joint.expected[i])
            for i, record in zip(rows, records, strict=True)
        ]
        errors = heading_errors(
            known, campaign.site.latitude, campaign.fixture.C_sb, K, campaign.sigma.heading, SOLVED
        )
        for error in errors:
            named = " or ".join(f"{records[i].position} ({records[i].name})" for i in sorted(error.dwells))
            said.append(f"position {named} {heading_error_text(error)}: record it again")
            sure += [records[i].name for i in error.dwells if len(error.dwells) == 1]
    return said, sure
