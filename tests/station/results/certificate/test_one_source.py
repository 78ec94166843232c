"""HTML and XML are made from one content: every number that is printed stands in the XML."""

import re
from collections.abc import Iterator
from itertools import product
from math import pi

import pytest
from lxml import etree

from station.results.certificate.dcc.digital_certificate import certificate_xml
from station.results.certificate.rendering import render
from tests.empty_database import empty_db
from tests.station.results.certificate.dcc_kinds import KINDS, of_kind
from tests.station.results.certificate.dcc_numbers import NS, all_numbers, of_type, parsed, read, results
from tests.station.results.certificate.test_certificate_inputs import seen

G = 9.80665
PRINTED = {  # what a printed unit is in that of the XML
    "count/(g\u00b7s)": G, "\u00b5g": 1e6 / G, "arcsec": 648000 / pi, "count/deg": 1.0, "deg/h": 1.0,
    "output/g": G, "output/(deg/s)": 1.0,
}  # fmt: skip
SCALES = (1.0, G, 1 / G, 1e6 / G, 648000 / pi, 100.0, 1e6)  # of the numbers that stand in sentences
SYMBOLS = {"K": "scale_factor", "E": "misalignment", "D": "bias"}
GROUP = re.compile(r'(?s)<tbody class="group">(.*?)</tbody>')
ROW = re.compile(
    r'<tr><td><i class="symbol">(\w)</i><sub>(\w+)</sub></td><td class="num value">([^<]+)</td>'
    r'<td class="num">([^<]+)</td><td>([^<]*)</td>' + 3 * r'<td class="num">([^<]+)</td>'
)
NUMBER = re.compile(r"(?<![\w.,])[\u2212+-]?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.]*\w)")
NOT_OF_THE_CERTIFICATE = {  # numbers of its form: sections, standards, formulas
    "0", "1", "2", "3", "4", "5", "6", "7", "8.3", "95", "100", "106", "17025", "-1", "+1",
}  # fmt: skip


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[str, bytes]]:
    """Return HTML and XML of every kind."""
    found = {}
    for number, kind in enumerate(KINDS):
        with empty_db(tmp_path_factory.mktemp("db") / f"{number}.db") as database, database.write() as session:
            content = of_kind(session, kind)
        found[kind] = render(content), certificate_xml(content)
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_remarks_are_the_same_sentences_in_both(both: dict[str, tuple[str, bytes]], kind: str) -> None:
    page, root = seen(both[kind][0]), parsed(both[kind][1])
    reported = {
        name: [str(text) for text in root.xpath(f"//*[@refType='{name}']//dcc:content/text()", namespaces=NS)]
        for name in ("fog_diagnosis", "fog_takenAsZero", "fog_kindOfDocument", "fog_amendment")
    }
    for english in (reported["fog_diagnosis"][0], reported["fog_takenAsZero"][0]):
        assert " ".join(english.split()) in " ".join(page.split())
    assert not re.search(
        r"\.[;.]|(Diagnose des Residuums: ){2}", " ".join(text for texts in reported.values() for text in texts)
    )
    assert "Reason: wrong address. Fields printed otherwise: Customer." in page
    assert "Reason: wrong address. Fields printed otherwise: Customer." in reported["fog_amendment"][0]
    title = "Calibration certificate of a simulated unit"
    assert (kind == "simulated") == (title in page) == (title in reported["fog_kindOfDocument"][0])


def printed(text: str) -> str:
    return text.strip("\u2007\u2008 ").replace("\u2212", "-")


def rounds_to(value: float, text: str) -> bool:
    """Say whether a number is printed so, at the place that was printed; half a place more is rounding's own."""
    decimals = len(text.partition(".")[2])
    return abs(value - float(text)) <= 0.5000001 * 10.0**-decimals


def shares(root: etree._Element) -> Iterator[float]:
    """Give what each contribution of the budget has of its parameter's variance."""
    for one in of_type(root, "fog_budget", "list"):
        _, *parts = [read(each).value ** 2 for each in one.findall("dcc:quantity", NS)]
        yield from (part / sum(parts) for part in parts)


@pytest.mark.parametrize("kind", KINDS)
def test_every_row_of_the_results_is_a_quantity_of_the_xml(both: dict[str, tuple[str, bytes]], kind: str) -> None:
    html, xml = both[kind]
    written, names = results(parsed(xml)), list[str]()
    for group in GROUP.findall(html):
        triad = re.search(r"<th[^>]*>(\w+):", group)
        assert triad is not None
        for letter, axis, *cells in ROW.findall(group):
            value, expanded, unit, k, dof, sigma = map(printed, cells)
            names.append(f"{triad[1].lower()}.{SYMBOLS[letter]}.{axis}")
            one, scale = written[names[-1]], PRINTED[unit]
            assert one.expanded is not None
            assert one.factor is not None
            assert rounds_to(one.value * scale, value)
            assert rounds_to(one.expanded * scale, expanded)
            assert rounds_to(one.factor, k)
            assert rounds_to(one.expanded / one.factor * scale, sigma)
            assert dof == ("\u221e" if one.dof is None or one.dof >= 1e4 else str(int(one.dof)))
    assert sorted(names) == sorted(written)


@pytest.mark.parametrize("kind", KINDS)
def test_every_printed_number_stands_in_the_xml(both: dict[str, tuple[str, bytes]], kind: str) -> None:
    html, xml = both[kind]
    root = parsed(xml)
    numbers = all_numbers(root) | set(shares(root))
    words = set(NUMBER.findall(" ".join(root.itertext()).replace("\u2212", "-")))
    text = re.sub(r"[0-9a-f]{16,}|\d{4}-\d\d-\d\d|\d\d:\d\d", " ", seen(html)).replace("\u2212", "-")
    reported = set(NUMBER.findall(text)) - NOT_OF_THE_CERTIFICATE
    assert len(reported) > 30
    lost = [
        number
        for number in reported
        if number not in words
        and not any(rounds_to(value * scale, number) for value, scale in product(numbers, SCALES))
    ]
    assert lost == []


def test_dates_and_hashes_that_are_printed_stand_in_the_xml(both: dict[str, tuple[str, bytes]]) -> None:
    for html, xml in both.values():
        text = " ".join(parsed(xml).itertext())
        hashes = {one for one in re.findall(r"\b[0-9a-f]{64}\b", seen(html)) if set(one) != {"0"}}
        assert hashes
        assert {one for one in hashes if one not in text} == set()
        days = set(re.findall(r"\b\d{4}-\d\d-\d\d\b", seen(html)))
        assert {day for day in days if day not in text} == set()
