"""What the sources of uncertainty are, for readers of a certificate.

docs/explanation/uncertainty.md has how each is found.
"""

from collections.abc import Iterable

from procedures.uncertainty import sources
from station.results.certificate.printed_results import MeasuredParameter, main_shares

MEANINGS = {
    sources.COUNTING: "the white noise of the unit\u2019s output",
    sources.QUANTISATION: "the size of one count",
    sources.INSTABILITY: "how far the bias wandered during the measurement",
    sources.REST_SCATTER: "how far repeated positions of rest differed beyond noise",
    sources.MOVE_SCATTER: "how far moves by hand differed beyond noise",
    sources.CONING: "rotation between two samples",
    sources.WARM_UP: "how far the unit had not settled after power-on",
    sources.TURN_ON: "how far the bias differed between power-ons",
    sources.CUBE: "the angles of the cube\u2019s faces",
    sources.SLAB: "the level of the slab",
    sources.HEADING: "the direction in which the cube was set down",
    sources.SEAT: "how the cube sat on the slab, anew each time it was set down",
    sources.CLOSURE: "how exactly a turn by hand ended in the direction in which it began",
    sources.GRAVITY: "the local gravity",
    sources.SECOND_ORDER: "what misalignment or tilts leave open in second order",
    sources.FRAME: "the axes to which free positions refer",
    sources.LATITUDE: "the latitude",
    sources.CLOCK: "the unit\u2019s clock",
    sources.TEMPERATURE: "how the results followed the temperature",
    sources.EFFECTS: "what the effects added to the model leave open",
    sources.UNEXPLAINED: "what of the residual no known effect explains",
}


def sources_said(results: Iterable[MeasuredParameter]) -> list[tuple[str, str]]:
    """Return each source that is printed among the main parts of the variance, with what it is."""
    found = {source for result in results for source, _ in main_shares(result)}
    return [(source, meaning) for source, meaning in MEANINGS.items() if source in found]
