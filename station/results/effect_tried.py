"""An `effect/1` tried on campaigns: what a diagnosis with it beside the catalogue says of it."""

from collections.abc import Sequence

from procedures.diagnosis.diagnose import diagnose
from procedures.effects import EFFECTS
from procedures.inference.result import Diagnosis
from station.files.campaign_folder.loaded_campaign import LoadedCampaign, effects_of
from station.files.effect_file import EffectFile
from station.results.diagnosis.diagnosis_json import finding_document
from station.results.diagnosis.diagnosis_wording import probability_text
from station.results.diagnosis.magnetic_field import with_magnetic_field
from station.results.solution_text import measured


def tried_text(file: EffectFile, campaigns: Sequence[LoadedCampaign]) -> str:
    """Return whether one unit's campaigns show an effect, with its coefficients, and what else it could be."""
    campaigns = [with_magnetic_field(one) for one in campaigns]
    declared = [one.term for one in effects_of(campaigns) if one.name != file.name]
    found = diagnose([one.campaign for one in campaigns], (*EFFECTS, file.effect), declared)
    lines = [f"{file.name}: {_answer(file, found)}", *_findings(file, found)]
    others = dict.fromkeys(one.effect for one in found.findings if one.effect != file.name)
    lines += [f"beside it: {', '.join(others)}"] if others else []
    return "\n".join([*lines, f"verdict: {found.verdict}"])


def _answer(file: EffectFile, found: Diagnosis) -> str:
    named = [one for one in found.findings if one.effect == file.name]
    if named:
        return f"it is present, {named[0].confidence} (probability {probability_text(named[0].probability)})"
    if missing := file.term.missing(found.evidence.excitation):
        return f"not tested: {', '.join(missing)} not recorded"
    if alike := [one.effect for one in found.findings if file.name in one.aliases]:
        return f"these campaigns cannot separate it from {', '.join(alike)}"
    if file.name in found.not_separable or file.name not in found.probabilities:
        return "these campaigns cannot determine it: the model's own parameters absorb it, or nothing excites it"
    return f"not found: its probability is {probability_text(found.probabilities[file.name])}"


def _findings(file: EffectFile, found: Diagnosis) -> list[str]:
    lines = list[str]()
    units = {name: one.unit for name, one in file.term.parameters.items()}
    for one in (one for one in found.findings if one.effect == file.name):
        for name, value in finding_document(one)["coefficients"].items():
            lines.append(f"  {name:<10} {measured(value['value'], value['std'], units.get(name, one.unit))}")
        values = dict(zip(one.coefficients, one.value.tolist(), strict=True))
        lines += [f"  {said}" for said in file.term.at_ends(values)]
        lines += [f"  it may also be {', '.join(one.aliases)}"] if one.aliases else []
    return lines
