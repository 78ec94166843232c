"""What the sources of uncertainty are, for readers of a certificate.

docs/explanation/uncertainty.md has how each is found.
"""

from collections.abc import Iterable

from procedures.uncertainty import sources
from station.results.certificate.printed_results import MeasuredParameter, main_shares

MEANINGS = {
    sources.COUNTING: "the white noise of the unit\u2019s output",
    sources.QUANTISATION: "the size of one count",
    sources.INSTABILITY: "bias instability during the measurement",
    sources.REST_SCATTER: "differences between repeated positions beyond noise",
    sources.MOVE_SCATTER: "differences between manual transfers beyond noise",
    sources.CONING: "rotation between two samples",
    sources.WARM_UP: "remaining warm-up drift after power-on",
    sources.TURN_ON: "bias differences between power-ons",
    sources.CUBE: "the angles of the cube\u2019s faces",
    sources.SLAB: "the level of the surface plate",
    sources.HEADING: "the heading in which the cube was set down",
    sources.SEAT: "the seating of the cube on the surface plate, different at each placement",
    sources.CLOSURE: "the closure error of a manual rotation",
    sources.GRAVITY: "the local gravity",
    sources.SECOND_ORDER: "second-order terms of misalignment and tilts",
    sources.FRAME: "the reference axes of free positions",
    sources.LATITUDE: "the latitude",
    sources.CLOCK: "the unit\u2019s clock",
    sources.TEMPERATURE: "the temperature dependence of the results",
    sources.EFFECTS: "the uncertainty of the error terms added to the model",
    sources.UNEXPLAINED: "the part of the residuals that no known error term explains",
}


def sources_said(results: Iterable[MeasuredParameter]) -> list[tuple[str, str]]:
    """Return each source that is printed among the main parts of the variance, with what it is."""
    found = {source for result in results for source, _ in main_shares(result)}
    return [(source, meaning) for source, meaning in MEANINGS.items() if source in found]
