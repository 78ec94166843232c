"""Whether a campaign can end in PASS and in a certificate, before it begins: a pure function of what is known.

The rules are those of `station.results.verdict.judge`, `fixtures_db.campaigns.why_measured` and
`station.results.certificate.missing_statements`. What a laboratory's file can still state later is not required.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from functools import cache
from pathlib import Path
from typing import Any

from fixtures_db.campaigns import day_of, is_expired, reference, why_measured
from fixtures_db.database import Database
from fixtures_db.fixtures import fixture_rows, is_surveyed_at
from fixtures_db.imu_models import UNITS, Limit, limited_models, limits_of
from fixtures_db.schema import CubeRow, SiteRow, SlabRow
from procedures.campaign.plan_steps import Step
from station.errors import megabytes
from station.files.campaign_folder.campaign_schema import GRAVITY_STD, NORMAL_GRAVITY_STD
from station.files.campaign_setup import Setup
from station.guide.campaign.folder_recorder import disk_free, disk_needed
from station.guide.setup_view import PortCheck, Readiness, ReadyLine, ReadyState
from station.results.certificate.missing_statements import missing_before


@dataclass(frozen=True, slots=True)
class PriorKnowledge:
    """``references`` of cubes and slabs by kind and id; ``limits`` by model.

    ``sites`` stand with their references. ``usual``: the steps are the usual ones. ``free`` and
    ``needed`` are bytes, None where that is not known.
    """

    today: date
    software: str
    limits: Mapping[str, Sequence[Limit]]
    references: Mapping[tuple[str, str], Mapping[str, Any]]
    sites: Sequence[tuple[SiteRow, Mapping[str, Any]]]
    usual: bool = True
    free: int | None = None
    needed: int | None = None


def read_prior_knowledge(
    database: Database, root: Path, steps: Sequence[Step], rate_hz: float | None, *, usual: bool = True
) -> PriorKnowledge:
    """Return what is known now, for a campaign of ``steps`` that goes beneath ``root``."""
    now = datetime.now(UTC)
    with database.read() as session:
        limits = {model: limits_of(session, model) for model in limited_models(session)}
        found = [reference(row, now) for row in fixture_rows(session, CubeRow)]
        found += [reference(row, now) for row in fixture_rows(session, SlabRow)]
        sites = [(row, reference(row, now)) for row in fixture_rows(session, SiteRow)]
    return PriorKnowledge(
        day_of(now), _software(), limits, {(one["kind"], one["id"]): one for one in found}, sites,
        usual, disk_free(root), None if rate_hz is None else disk_needed(steps, rate_hz),
    )  # fmt: skip


@cache
def _software() -> str:
    from station.results.solution_json import software_version

    return software_version()


# closed forms of accelerometers alone
NEVER_DETERMINED = ("gyroscope.bias_12_position", "gyroscope.bias_two_direction")
NO_COMMIT = "the station runs neither from a checkout nor from an installed wheel"
StateAndText = tuple[ReadyState, str]  # of a line
SAYS_NONE = {"operator": "no operator", "software.commit": NO_COMMIT}


def readiness(
    setup: Setup, known: PriorKnowledge, check: PortCheck | None = None, receiver: PortCheck | None = None
) -> Readiness:
    """Return what is there and what lacks, one line each, and how the campaign can end.

    ``check`` and ``receiver`` are the newest looks; those of other addresses than the set-up's say nothing.
    """
    check = check if check is not None and check.url == setup.url and check.is_good else None
    receiver = receiver if receiver is not None and receiver.url == setup.gnss else None
    model = (check.model if check else "") or setup.model
    no_pass = _no_pass(model, check, known)
    used = [_chosen("cube", setup, known), _chosen("slab", setup, known), _survey(setup, known)]
    lacks = _lacks(setup, known)
    only_measured = [] if lacks else why_measured([one for one in used if one], known.today)
    no_certificate = f"a measurement report: {'; '.join(only_measured)}" if only_measured else "; ".join(lacks)
    lines: dict[str, StateAndText] = {
        "limits": _limits(model, no_pass, known), "operator": _operator(setup),
        "cube": _fixture("cube", setup.cube, known), "slab": _fixture("slab", setup.slab, known),
        "site": _site(setup, known), "disk": _disk(known), "receiver": _receiver(setup, receiver),
    }  # fmt: skip
    if NO_COMMIT in lacks:
        lines["software"] = "lacks", NO_COMMIT
    return Readiness(
        lines=tuple(ReadyLine(name=name, state=state, text=text) for name, (state, text) in lines.items()),
        can_pass=None if no_pass is None else not no_pass, no_pass=no_pass or "",
        can_certify=not no_certificate, no_certificate=no_certificate,
    )  # fmt: skip


def _no_pass(model: str, check: PortCheck | None, known: PriorKnowledge) -> str | None:
    """Say why it cannot end in PASS, empty if it can; None while the model is not known."""
    if not model:
        return None
    if not (limits := known.limits.get(model)):
        return f"no limits are stored for {model}"
    never = [one.parameter for one in limits if _is_never(one, check, usual=known.usual)]
    return f"{never[0]} has a limit but the steps do not determine it" if never else ""


def _is_never(limit: Limit, check: PortCheck | None, *, usual: bool) -> bool:
    units = UNITS[limit.parameter]
    if check is not None and check.output and len(units) == 2 and limit.unit != units[check.output == "rate"]:
        return True
    return usual and limit.parameter.startswith(NEVER_DETERMINED)


def _lacks(setup: Setup, known: PriorKnowledge) -> list[str]:
    """Return in words what a certificate needs and could never be given afterwards."""
    references = [one for kind in ("cube", "slab") if (one := _chosen(kind, setup, known)) is not None]
    own = {"operator": setup.operator, "software": known.software, "references": references}
    document = {"model": "from the unit", "serial": "from the unit", **own}
    return list(dict.fromkeys(_in_words(field, setup, known) for field in missing_before(document)))


def _in_words(field: str, setup: Setup, known: PriorKnowledge) -> str:
    if field in SAYS_NONE:
        return SAYS_NONE[field]
    kind = field.split(".")[1]
    name, one = getattr(setup, kind), _chosen(kind, setup, known)
    if not name:
        return f"no {kind}"
    if one is None:
        return f"{kind} {name} is not in the database"
    return f"{kind} {name} has no {'due date' if 'source' in one else 'certificate'}"


def _chosen(kind: str, setup: Setup, known: PriorKnowledge) -> Mapping[str, Any] | None:
    return known.references.get((kind, getattr(setup, kind)))


def _survey(setup: Setup, known: PriorKnowledge) -> Mapping[str, Any] | None:
    if setup.gravity_m_s2 is None or setup.latitude_deg is None:
        return None
    stated = setup.latitude_deg, setup.gravity_m_s2, setup.gravity_std_m_s2 or GRAVITY_STD
    return next((reference for site, reference in known.sites if is_surveyed_at(site, *stated)), None)


def _limits(model: str, no_pass: str | None, known: PriorKnowledge) -> StateAndText:
    if not model:
        return "note", "model unknown: check the port first"
    if no_pass:
        remedy = f"; `station fixtures limits {model} --example`" if model not in known.limits else ""
        return "lacks", no_pass + remedy
    return "ready", f"{len(known.limits[model])} for {model}"


def _operator(setup: Setup) -> StateAndText:
    if setup.operator:
        return "ready", setup.operator
    return "lacks", "no operator is named; a certificate needs one"


def _fixture(kind: str, name: str, known: PriorKnowledge) -> StateAndText:
    one = known.references.get((kind, name))
    if not name:
        return "lacks", f"no {kind} is chosen"
    if one is None:
        return "lacks", f"{name} is not in the database: `station fixtures add {kind}`"
    due = one.get("due_date")
    if due is not None and is_expired(date.fromisoformat(due), known.today):
        return "lacks", f"{name}, its certificate expired on {due}"
    if "source" not in one:
        what = "certificate" if kind == "cube" else "level"
        return "lacks", f"{name} has no certificate: `station fixtures add {what}`"
    if due is None:
        return "lacks", f"{name}, its certificate has no due date"
    return "ready", f"{name}, certificate due {due}"


def _site(setup: Setup, known: PriorKnowledge) -> StateAndText:
    if setup.gravity_m_s2 is None:
        return "note", f"gravity from latitude and height, known to {NORMAL_GRAVITY_STD:g} m/s2: not a survey"
    if setup.latitude_deg is None:
        return "note", "its survey is looked up when the receiver gives the latitude"
    if (survey := _survey(setup, known)) is None:
        return "note", "no survey with this gravity is stored; name one in the laboratory file"
    name, due = survey["id"], survey.get("due_date")
    if due is not None and is_expired(date.fromisoformat(due), known.today):
        return "lacks", f"{name}, its survey expired on {due}"
    return "ready", f"{name}, surveyed" + (f", due {due}" if due else "")


def _disk(known: PriorKnowledge) -> StateAndText:
    if known.free is None:
        return "note", "the free disk space is not known"
    free = f"{megabytes(known.free)} free"
    if known.needed is None:
        return "note", f"{free}; the space needed depends on the port's rate"
    return "ready" if known.free >= known.needed else "lacks", f"{free}, about {megabytes(known.needed)} needed"


def _receiver(setup: Setup, receiver: PortCheck | None) -> StateAndText:
    if not setup.gnss:
        return "note", "none: the clock of this computer is used"
    if receiver is None:
        return "note", "not checked yet"
    return "ready" if receiver.is_good else "lacks", receiver.text
