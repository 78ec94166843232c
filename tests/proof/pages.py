"""The page docs/evidence/README.md, from the JSON files of its folder."""

import json
from collections.abc import Mapping
from typing import Any

from tests.proof.evidence import EVIDENCE, Figure, figures
from tests.proof.registry import PROOFS

PAGE = EVIDENCE / "README.md"
HEAD = """# Evidence

What the long statistical runs of `make proof` measured
([how to run them](../contributing/station-tests.md#make-proof)).
This page is generated from the JSON files in this folder: `python -m tests.proof --pages`.
"""


def page() -> str:
    """Return the page."""
    contents, sections = ["| proof | what it shows | numbers as asked |", "|---|---|---|"], list[str]()
    for proof in PROOFS.values():
        if proof.file.exists():
            known = json.loads(proof.file.read_text(encoding="utf-8"))
            contents.append(_line(known))
            sections.append("\n" + _section(known))
        else:
            contents.append(f"| [{proof.name}](#{proof.name}) | {proof.shows} | not run yet |")
            sections.append(
                f"\n## {proof.name}\n\n{proof.shows} Not run yet: `python -m tests.proof {proof.name}`."
            )
    return "\n".join([HEAD, *contents, *sections]) + "\n"


def _line(document: Mapping[str, Any]) -> str:
    asked = [each for each in figures(document).values() if _asked(each)]
    met = sum(each.is_met for each in asked)
    return f"| [{document['name']}](#{document['name']}) | {document['shows']} | {met} of {len(asked)} |"


def _section(document: Mapping[str, Any]) -> str:
    machine, size = document["machine"], document["size"]
    rows = [
        f"| {name} | {_measured(each)} | {_asked(each)}{'' if each.is_met else ', **not met**'} |"
        for name, each in figures(document).items()
    ]
    return "\n".join([
        f"## {document['name']}\n\n{document['shows']}\n\n| number | measured | asked |\n|---|---|---|",
        *rows,
        f"\n{size['value']:,} {size['unit']}, seed {document['seed']}, in {document['seconds']:g} s on "
        f"{machine['cores']} cores of {machine['cpu']}, Python {machine['python']}; program of commit "
        f"{document['commit']}, {document['date']}: `{document['command']}`",
    ])  # fmt: skip


def _measured(figure: Figure) -> str:
    of = "" if figure.of is None else f" of {figure.of:,}"
    return f"{_number(figure.value)} {figure.unit}".rstrip() + of


def _asked(figure: Figure) -> str:
    if figure.at_least is not None and figure.at_most is not None:
        return f"{_number(figure.at_least)} to {_number(figure.at_most)}"
    if figure.at_most is not None:
        return f"at most {_number(figure.at_most)}" if figure.at_most else "0"
    return "" if figure.at_least is None else f"at least {_number(figure.at_least)}"


def _number(value: float) -> str:
    return f"{value:,.0f}" if float(value).is_integer() else f"{value:.4g}"
