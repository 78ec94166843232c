"""The covariance matrix of a digital certificate, in blocks: of two kinds of parameters, all of one unit.

A list of the D-SI that readers take whole has one unit, the matrix one for every pair of kinds. So it is given as
the blocks of its upper triangle, each by rows, labelled ``row|column``. It is the fit's, as the solution has it:
a parameter's U rests on sources beyond the fit too, and its u^2 is at least the matrix's diagonal.
"""

from collections.abc import Iterator, Mapping

from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.elements import Element, Said, dcc, worded
from station.results.certificate.dcc.names import PART_NAMES, TRIAD_NAMES
from station.results.certificate.dcc.quantities import numbers, quantity
from station.results.certificate.dcc.results import result, unit_of

TITLE = Said("Covariance matrix of the fit", "Kovarianzmatrix der Ausgleichung")
MEANING = Said(
    "Covariances of the parameters as the least-squares solution gives them, by blocks of the upper triangle, "
    "each by "
    "rows; a label names row and column. The combined uncertainty U / k of a parameter includes sources beyond "
    "the fit, "
    "named in the budget.",
    "Kovarianzen der Parameter, wie die Ausgleichung sie liefert: Blöcke des oberen Dreiecks, jeder "
    "zeilenweise; ein "
    "Etikett nennt Zeile und Spalte. Die kombinierte Unsicherheit U / k eines Parameters enthält auch Quellen "
    "außerhalb der Ausgleichung, die das Budget nennt.",
)


def covariance_results(content: CertificateContent) -> Iterator[Element]:
    """Give the matrix, if the calibration holds one; those stored before there was one do not."""
    stored = content.document.get("covariance", {"names": []})
    if not (groups := _groups(content, stored["names"])):
        return
    kinds = list(groups)
    blocks = [
        _block(content, stored, groups, (row, column))
        for place, row in enumerate(kinds)
        for column in kinds[place:]
    ]
    whole = dcc("list", worded("name", TITLE), worded("description", MEANING), *blocks, refType="fog_covariance")
    yield result(TITLE, whole, ref_type="fog_covarianceMatrix")


def _groups(content: CertificateContent, names: list[str]) -> dict[str, list[str]]:
    """Return the parameters of the certificate that the matrix has, by triad and kind."""
    found = dict[str, list[str]]()
    for name in content.results:
        if name in names:
            found.setdefault(name.rpartition(".")[0], []).append(name)
    return found


def _block(
    content: CertificateContent,
    stored: Mapping[str, list[str]],
    groups: dict[str, list[str]],
    pair: tuple[str, str],
) -> Element:
    rows, columns = (groups[kind] for kind in pair)
    at = {name: place for place, name in enumerate(stored["names"])}
    units = [unit_of(content.results[names[0]].unit) for names in (rows, columns)]
    values = [float(stored["matrix"][at[row]][at[column]]) for row in rows for column in columns]
    labels = [f"{row}|{column}" for row in rows for column in columns]
    one, other = (_kind_name(kind) for kind in pair)
    return quantity(
        one + Said(" \u00d7 ", " \u00d7 ") + other,
        numbers(values, units[0] * units[1], labels),
        ref_type="fog_covarianceBlock",
        refId=" ".join(dict.fromkeys((*rows, *columns))),
    )


def _kind_name(kind: str) -> Said:
    triad, part = kind.split(".")
    return TRIAD_NAMES[triad] + Said(" ", ", ") + PART_NAMES[part]
