"""The pages of reports, certificates, histories and diagnoses: templates that may include one another."""

import re
from functools import cache

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup, escape

from station.text import unit_in_words

FOLDERS = ("report", "diagnosis", "history", "certificate")


def html_template(name: str) -> Template:
    """Return a template; ``typeset``, ``led`` and ``symbols`` are filters of it."""
    return _environment().get_template(name)


@cache
def _environment() -> Environment:
    loader = ChoiceLoader([PackageLoader(f"station.results.{folder}") for folder in FOLDERS])
    made = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    made.filters |= {"typeset": _typeset, "led": _led, "symbols": _symbols}
    made.globals["unit_in_words"] = unit_in_words
    return made


def _led(text: str) -> Markup:
    """Return text with what leads up to its first colon or full stop in bold."""
    lead, mark, rest = re.split("([:.])", text, maxsplit=1)
    return Markup("<b>{}{}</b>{}").format(lead, mark, rest)


def _symbols(text: str) -> Markup:
    """Return text with the symbols of quantities in italics."""
    return Markup(re.sub(r"\b(r u|[kruwU])\b", r'<i class="symbol">\1</i>', str(escape(text))))


def _typeset(text: str) -> str:
    """Return text with the signs that a terminal may lack."""
    for plain, sign in (("+-", "\u00b1"), ("->", "\u2192"), ("ug", "\u00b5g"), ("um", "\u00b5m")):
        text = re.sub(rf"(?<!\w){re.escape(plain)}(?!\w)", sign, text)
    return re.sub(r"\bsqrt\((\w+)\)", "\u221a\\1", text)
