"""What a `diagnosis/2` says in place of a solution, where recordings determine no calibration: document and lines.

These are rests and transfers of a sequence, rotations, and single channels of a triad that is not solved.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from statistics import fmean
from typing import Any

from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import channel
from procedures.counts.sample_records import Series
from procedures.diagnosis.rotation_summary import TurnSeen, left_open, moves_seen, pooled, rests_seen, turns_seen
from procedures.diagnosis.single_channels import SingleChannel, single_channels
from procedures.effects.excitation import UNITS_OF_NONLINEAR
from procedures.frames import AXES, TRIADS
from procedures.statistics.allan_deviation import NoiseTerm
from procedures.statistics.line_fits import CorrelatedLine
from procedures.units import DEG_H_PER_DEG_S, S_PER_H, UG_PER_G
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.files.effect_file import stored_effect
from station.results.result_formats import document_of
from station.results.solution_json import provenance
from station.results.solution_text import measured

OUTPUT = "output"  # the unit of a triad whose unit is not specified, and whose columns name none
PARTS = ("scale_factor", "misalignment", "bias")
_SIZES = ("value", "std", "before", "after", "held_out_before", "held_out_after")


def without_solution(campaigns: Sequence[LoadedCampaign]) -> dict[str, Any]:
    """Return what stays open, the recordings' warnings and where they come from."""
    warnings = list(dict.fromkeys(w for loaded in campaigns for w in loaded.warnings))
    return {
        "not_observable": [f"{triad}.{part}" for triad in recorded_triads(campaigns) for part in PARTS],
        "warnings": warnings,
        "provenance": document_of(provenance(campaigns)),
    }


def recorded_triads(campaigns: Sequence[LoadedCampaign]) -> list[str]:
    """Return the triads of which something was recorded."""
    series, turned = list[Series](), set[str]()
    for one in (each.campaign for each in campaigns):
        for steps in (one.dwells, one.turns, one.rests, one.moves, one.sequences, one.soaks):
            series += [step.series for step in steps]
        turned |= {"gyroscope"} if one.rate_tables else set()
    return [triad for triad in TRIADS if triad in turned or any(channel(s, triad) is not None for s in series)]


def output_unit(campaigns: Sequence[LoadedCampaign], triad: str) -> str:
    """Return the unit of a triad's outputs as they were recorded, where that is none of rates or accelerations."""
    return (campaigns[0].output_name if triad == "gyroscope" else "") or OUTPUT


def in_specified_unit(part: Mapping[str, Any], of: str, campaigns: Sequence[LoadedCampaign]) -> dict[str, Any]:
    """Return a finding with its errors, or an error, in outputs where its triad's unit is not specified.

    Without one the outputs were taken for g and deg/s; ``of`` begins with the triad's name.
    """
    found = dict(part)
    if "error" in part:
        found["error"] = [in_specified_unit(each, each["quantity"], campaigns) for each in part["error"]]
    head, slash, rest = part["unit"].partition("/")
    is_rate = head == "deg" and rest.startswith("h")
    by_unit = "accelerometer" if head == "g" else "gyroscope" if is_rate else None  # of what acts on any channel
    triad = next((name for name in TRIADS if of.startswith(name)), by_unit)
    if triad is None or triad in campaigns[0].campaign.nominal_scale or head not in {"g", "deg"}:
        return found
    factor = 1.0
    if head == "deg" and (rest == "h" or rest.startswith("h/")):  # deg/h, deg/h/K; an output counts as deg/s
        factor, rest = 1 / DEG_H_PER_DEG_S, rest.removeprefix("h").removeprefix("/")
        slash = "/" if rest else ""
    found.pop("times_expected", None)  # of a size in g or deg/h
    return _times(found, factor, _parameters(found)) | {"unit": f"{output_unit(campaigns, triad)}{slash}{rest}"}


def _parameters(part: Mapping[str, Any]) -> frozenset[str]:
    """Return what is fitted besides coefficients, in a unit of its own."""
    if "definition" not in part:
        return frozenset(UNITS_OF_NONLINEAR)
    return frozenset(stored_effect(part["definition"], part["sha256"], part["effect"]).term.parameters)


def _times(part: Mapping[str, Any], factor: float, kept: frozenset[str] = frozenset()) -> dict[str, Any]:
    return {
        name: {key: dict(one) if key in kept else _times(one, factor) for key, one in value.items()}
        if name == "coefficients"
        else value * factor
        if name in _SIZES
        else value
        for name, value in part.items()
    }


MAX_TRANSFERS_SHOWN = 20


def rests_and_moves(campaigns: Sequence[Campaign]) -> dict[str, Any]:
    """Return ``rests`` and ``moves``, each absent where there is none."""
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
        off = [each[key] for each in rests if key in each]  # none where the unit is not specified
        rms = 1e3 * sqrt(fmean(x * x for x in off)) if off else 0.0
        seconds = [each["seconds"] for each in rests]
        text = f", specific force differs from gravity by {rms:.3g} mg rms" if off else ""
        yield f"{len(rests)} rests of {min(seconds):.1f} to {max(seconds):.1f} s{text}"
    if moves:
        yield "transfers as measured: by the gyroscopes x, y, z [deg]; rotation of gravity by the"
        yield "accelerometers, and its difference to the gyroscopes [deg]"
    for each in moves[:MAX_TRANSFERS_SHOWN]:
        x, y, z = each["turned_deg"]
        gravity = f"{each['tilted_deg']:8.2f} {each['apart_deg']:7.2f}" if "tilted_deg" in each else ""
        yield f"   {each['name'][-24:]:<24} {x:9.2f} {y:9.2f} {z:9.2f} {gravity}"
    if len(moves) > MAX_TRANSFERS_SHOWN:
        yield f"   ... and {len(moves) - MAX_TRANSFERS_SHOWN} more"


def turns(campaigns: Sequence[Campaign]) -> dict[str, Any]:
    """Return ``turns``, what they do not show (``turns_leave_open``), and the mean of several (``turns_mean``)."""
    seen = turns_seen(campaigns)
    if not seen:
        return {}
    nominal = campaigns[0].nominal_scale.get("gyroscope")
    mean = [
        {"channel": f"gyroscope {AXES[sensor]}", "scale_factor": _rotation_value(*scale, _rotation_unit(seen[0]))}
        for sensor, scale in pooled(seen).items()
    ]
    found: dict[str, Any] = {
        "turns": [_rotation_document(each, nominal) for each in seen],
        "turns_leave_open": left_open(seen),
    }
    return found | ({"turns_mean": mean} if mean else {})


def _rotation_unit(seen: TurnSeen) -> str:
    return "count/deg" if seen.is_count else "output/(deg/s)"


def _rotation_value(value: float, std: float, unit: str) -> dict[str, Any]:
    return {"value": value, "std": std, "unit": unit}


def _rotation_document(seen: TurnSeen, nominal: float | None) -> dict[str, Any]:
    document: dict[str, Any] = {
        "recording": seen.name, "axis": seen.axis, "channel": f"gyroscope {AXES[seen.sensor]}",
        "revolutions": seen.revolutions, "angle_deg": 360.0 * seen.revolutions, "seconds": seen.seconds,
    }  # fmt: skip
    is_whole = seen.revolutions % 1 == 0
    if is_whole:
        document["revolutions"] = int(seen.revolutions)
    if seen.scale is not None:
        document["scale_factor"] = _rotation_value(*seen.scale, _rotation_unit(seen))
    if seen.at_rest is not None:
        per = DEG_H_PER_DEG_S / nominal if nominal else 1.0
        unit = "deg/h" if nominal else "count/s" if seen.is_count else "output"
        document["at_rest"] = _rotation_value(seen.at_rest[0] * per, seen.at_rest[1] * abs(per), unit)
    if seen.turned_deg is not None:
        document["turned"] = _rotation_value(*seen.turned_deg, "deg")
        if seen.is_as_stated:
            document["beyond_whole_turns" if is_whole else "beyond_angle_told"] = _rotation_value(
                seen.turned_deg[0] - 360.0 * seen.revolutions, seen.turned_deg[1], "deg"
            )
    return document


def turns_lines(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield what `turns` found, as text in 80 columns; +- is the standard uncertainty."""
    for each in document.get("turns", []):
        yield f"{each['channel']}, {each['axis']} in {each['recording']}, {each['seconds']:.0f} s"
        for key, name in (
            ("scale_factor", "scale factor"), ("turned", "turned"), ("beyond_whole_turns", "beyond whole turns"),
            ("beyond_angle_told", "beyond stated angle"), ("at_rest", "at rest"),
        ):  # fmt: skip
            if key in each:
                yield f"   {name:<20}{measured(each[key]['value'], each[key]['std'])} {each[key]['unit']}"
    for each in document.get("turns_mean", []):
        scale = each["scale_factor"]
        yield f"{each['channel']}, all turns: {measured(scale['value'], scale['std'])} {scale['unit']}"
    if "turns" in document:
        rested = any("at_rest" in each for each in document["turns"])
        yield (
            "at rest is the bias with the Earth's rate along the axis; " if rested else ""
        ) + "not determined by this:"
        yield from (f"   {text}" for text in document["turns_leave_open"])


def channels_of(campaigns: Sequence[LoadedCampaign], solved: Sequence[str]) -> list[dict[str, Any]]:
    """Return what the live channels of triads that are not ``solved`` show by themselves."""
    found = single_channels([one.campaign for one in campaigns], solved)
    return [_channel_document(each, _unit_of(each, campaigns)) for each in found]


@dataclass(frozen=True, slots=True)
class _ChannelUnit:
    """In which unit a channel's outputs are scales, and its noise, and what they are multiplied by."""

    name: str
    factor: float
    noise_name: str
    noise_factor: float


def _unit_of(found: SingleChannel, campaigns: Sequence[LoadedCampaign]) -> _ChannelUnit:
    """Return the unit by a gyroscope's own scale factor, else by the specified unit, else the output itself."""
    scales = campaigns[0].campaign.nominal_scale
    scale = found.scale[0] if found.scale is not None else scales.get(found.triad)
    if scale is None:
        counts = campaigns[0].tables.imu.output != "rate"
        name = "count/s" if counts else output_unit(campaigns, found.triad)
        return _ChannelUnit(name, 1.0, f"{name} sqrt(s)", 1.0)
    if found.triad == "gyroscope":
        return _ChannelUnit("deg/h", DEG_H_PER_DEG_S / scale, "deg/sqrt(h)", S_PER_H**0.5 / abs(scale))
    return _ChannelUnit("ug", UG_PER_G / scale, "ug/sqrt(Hz)", UG_PER_G / abs(scale))


def _channel_document(found: SingleChannel, unit: _ChannelUnit) -> dict[str, Any]:
    document: dict[str, Any] = {
        "channel": f"{found.triad} {found.axis}",
        "recording": found.recording,
        "seconds": found.seconds,
    }
    if found.scale is not None:
        of_scale = "count/deg" if found.is_count else "output/(deg/s)"
        document["scale_factor"] = {"value": found.scale[0], "std": found.scale[1], "unit": of_scale}
    document["mean"] = {"value": found.mean * unit.factor, "unit": unit.name}
    document |= _noise_term("random_walk", found.noise, unit.noise_factor, unit.noise_name)
    document |= _noise_term("bias_instability", found.instability, abs(unit.factor), unit.name)
    document |= _correlated_line("drift", found.drift, unit.factor, f"{unit.name}/h")
    document |= _correlated_line("by_temperature", found.warming, unit.factor, f"{unit.name}/K")
    document |= {"temperature_moved_k": found.kelvin}
    return document | ({"is_confounded": True} if found.is_confounded else {})


def _noise_term(name: str, term: NoiseTerm, factor: float, unit: str) -> dict[str, Any]:
    if term.value is None:
        return {}
    sizes = {"value": term.value, "low": term.low, "high": term.high}
    return {name: {**{key: size * factor for key, size in sizes.items()}, "unit": unit}}


def _correlated_line(name: str, line: CorrelatedLine | None, factor: float, unit: str) -> dict[str, Any]:
    if line is None:
        return {}
    return {name: {"value": line.slope * factor, "std": line.std * abs(factor), "unit": unit}}
