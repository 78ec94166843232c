"""Rests and moves of a sequence that is not solved, as `diagnosis/2` and as lines."""

from collections.abc import Iterator, Mapping, Sequence
from math import sqrt
from statistics import fmean
from typing import Any

from procedures.campaign.campaign import Campaign
from procedures.diagnosis.rotation_summary import moves_seen, rests_seen

MAX_MOVES = 20


def rests_and_moves(campaigns: Sequence[Campaign]) -> dict[str, Any]:
    """Return ``rests`` and ``moves``, each left out where there is none."""
    rests = [
        {"name": each.name, "seconds": each.seconds}
        | ({} if each.excess is None else {"specific_force_less_gravity_g": each.excess})
        for each in rests_seen(campaigns)
    ]
    moves = [
        {"name": each.name, "seconds": each.seconds, "turned_deg": each.turned.tolist(), "angle_deg": each.angle}
        | ({} if each.tilted is None else {"tilted_deg": each.tilted, "apart_deg": each.apart})
        for each in moves_seen(campaigns)
    ]
    return {name: found for name, found in (("rests", rests), ("moves", moves)) if found}


def rests_and_moves_lines(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield what `rests_and_moves` found, as text in 80 columns."""
    rests, moves = document.get("rests", []), document.get("moves", [])
    if rests:
        key = "specific_force_less_gravity_g"
        off = [each[key] for each in rests if key in each]  # none where the unit is not told
        rms = 1e3 * sqrt(fmean(x * x for x in off)) if off else 0.0
        seconds = [each["seconds"] for each in rests]
        said = f", specific force differs from gravity by {rms:.3g} mg rms" if off else ""
        yield f"{len(rests)} rests of {min(seconds):.1f} to {max(seconds):.1f} s{said}"
    if moves:
        yield "transfers as measured: by the gyroscopes x, y, z [deg]; rotation of gravity by the"
        yield "accelerometers, and its difference to the gyroscopes [deg]"
    for each in moves[:MAX_MOVES]:
        x, y, z = each["turned_deg"]
        gravity = f"{each['tilted_deg']:8.2f} {each['apart_deg']:7.2f}" if "tilted_deg" in each else ""
        yield f"   {each['name'][-24:]:<24} {x:9.2f} {y:9.2f} {z:9.2f} {gravity}"
    if len(moves) > MAX_MOVES:
        yield f"   ... and {len(moves) - MAX_MOVES} more"
