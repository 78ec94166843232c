"""A campaign that was begun: its placings as a design has them, and what comes next in words."""

from pathlib import Path

import numpy as np

from fixtures_db.model_limits import UNITS
from procedures.frames import ATTITUDES, face_of
from procedures.planning.campaign_design import TURNS, Placing
from procedures.planning.design_sigmas import NAMES
from procedures.planning.sequential import NextPlacing
from procedures.planning.wanted_sigmas import WantedSigmas
from procedures.units import PPM_PER_ONE, S_PER_MIN
from station.files.campaign_folder.campaign_reading import read_campaign
from station.results.parameters_by_name import title_of
from station.results.planning.plan_text import DIGITS, SHOWN
from station.text.rounding import significant


def placings_of(folder: Path) -> list[Placing]:
    """Return the dwells and turns of a campaign's folder in the order of their times; raise as `read_campaign`."""
    campaign = read_campaign(folder).campaign
    numbers = {step.name: i for i, step in enumerate(TURNS)}
    found = [
        (float(each.series.t[0]), Placing(each.position, len(each.series) * each.series.period))
        for each in campaign.dwells
    ]
    for turn in campaign.turns:
        name = f"turn_{turn.axis}_{'plus' if turn.direction == '+' else 'minus'}"
        found.append((float(turn.series.t[0]), Placing(turn.start_position, 0.0, numbers[name])))
    return [placing for _, placing in sorted(found, key=lambda each: each[0])]


def continued_text(found: NextPlacing, asked: WantedSigmas) -> str:
    """Return how far each asked sigma is, how long it will take, and the next placing."""
    lines = sigmas_so_far(found, asked)
    if not found.is_reachable:
        lines.append("what is wanted is out of reach of the placings that are left")
    elif found.placing is not None:
        lines.append(f"about {np.ceil(found.seconds / S_PER_MIN):.0f} min left")
    if found.placing is None:
        return "\n".join([*lines, "all that is wanted is met: stop, or go on"])
    axes, up = ATTITUDES[found.placing.position - 1], face_of(found.placing.position).replace("_", " ")
    return "\n".join([*lines, f"next: {axes}, {up}, for {found.placing.seconds:.0f} s"])


def sigmas_so_far(found: NextPlacing, asked: WantedSigmas) -> list[str]:
    """Return such as ``gyroscope bias 0.013 of 0.020 deg/h`` of every asked triad and kind, by its worst axis."""
    ratios, worst = asked.ratios(found.sigmas), dict[str, int]()
    for i, name in enumerate(NAMES):
        if np.isfinite(asked.sigma[i]):
            kind = name.rpartition(".")[0]
            worst[kind] = max(worst.get(kind, i), i, key=lambda j: float(ratios[j]))
    return [f"{title_of(kind)} {_of(found.sigmas[i], asked.sigma[i], NAMES[i])}" for kind, i in worst.items()]


def _of(now: float, wanted: float, name: str) -> str:
    times, unit = (
        (PPM_PER_ONE, "ppm") if ".scale_factor" in name else SHOWN.get(UNITS[name][0], (1.0, UNITS[name][0]))
    )
    reached = significant(times * now, DIGITS) if np.isfinite(now) else "open"
    return f"{reached} of {significant(times * wanted, DIGITS)} {unit}"
