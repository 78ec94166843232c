"""Every chosen number of the inference, with unit and reason; guards against a division by zero are elsewhere."""

from typing import Literal

import numpy as np

Confidence = Literal["established", "likely", "possible"]

# What acts.
# Of about forty names in the catalogue, a unit on its bench shows between none and two. A term of the bench or of
# the procedure is as likely as one of the instrument, and so is a class of rows noisier than its samples say.
ODDS_NAMED = 0.01
# About twenty families hold what no catalogue lists. Together they act a tenth as often as the catalogue.
ODDS_NAMELESS = 0.002
# The library of terms holds laws that no catalogue lists: all together they are as likely as the functions are.
ODDS_TERMS = 0.04
# Every factor and parameter makes a term of the library so much less likely [nats]: the simplest first.
SIMPLER = 2.0
# Where one coefficient of an error term acts, another of it acts in one of four cases.
ODDS_ANOTHER = 0.3

# How large it is.
# The catalogue states the standard deviation of a coefficient: smaller ones are as likely, larger ones rarer. The
# procedure states that of a scatter and the samples that of the noise: each is right within a factor of ten.
FACTOR = 10.0
# Sizes span three decades: good units show a thousandth of the catalogue's number, which is of the largest. A
# nameless function spans them from 1 sigma of all rows together, below which nothing shows.
SPAN = 1000.0
AMPLITUDES = 25  # points of a logarithmic grid: neighbours differ by less than half a standard deviation
FINER_AMPLITUDES = 10  # points for each of these where the amplitude is the result: a hundred draws tell it to 7 %

# What form it has.
# s: half decades from the settling of a servo to the warming of a case; what lags the temperature, or fades.
TIMES_S = (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)
# Half periods over the range of its coordinate, beyond which a smooth function's spectrum falls off as k^-4. The
# smallest is no straight line, which has a name; the largest is all that the steps of a campaign resolve.
BENDS = (3.0, 10.0)
# Parts of the largest input at which the end of the range begins. The first is also how wide a zone is.
KNEES = (0.3, 0.5, 0.7, 0.85)
FINER = 3  # points in each interval of a time constant's grid: a third of 0.5 in its logarithm changes nothing

# A time constant of which less than this share of the squares adds to the effect without it is the plain
# effect, unless the data resolve it all the same: a lag shows where it shifts the response by a fifth.
UNRESOLVED = 0.05

# How exact the answer is.
NEGLIGIBLE = 0.01  # a share that changes no word and no second decimal
BREADTH = 3  # models of one size from which the next are grown
MOST_PLACES = 2  # of one cause within a triad: a unit that jumps more often follows a curve of its own
LARGEST = 8  # causes in a model: a unit with more needs a repair, no diagnosis

ESTABLISHED, LIKELY = 0.99, 0.9  # probability from which a cause is called so
PRESENT = 0.5  # probability from which a cause changes the verdict: likelier than not


def grid(low: float, high: float) -> np.ndarray:
    """Return amplitudes (m,) [1] of equal weight, evenly spread in the logarithm."""
    found: np.ndarray = np.geomspace(low, high, AMPLITUDES)
    return found


def log_weights(amplitudes: np.ndarray) -> np.ndarray:
    """Return ln of the weights (m,) of amplitudes (m,) [1], of mean 1: beyond 1 as rare as a Cauchy tail."""
    weights = 1 / (1 + amplitudes)
    found: np.ndarray = np.log(weights / np.mean(weights))
    return found


OF_NAMED = grid(1 / SPAN, FACTOR)  # of the standard deviation of a coefficient that the catalogue states
OF_SPREAD = grid(1 / FACTOR, FACTOR)  # of the standard deviation of a scatter, or of noise, that is stated
OF_NAMELESS = grid(1.0, SPAN)  # of what one sigma of all rows together is
WINDOW = -2 * np.log(NEGLIGIBLE)  # nats below the best model: a hundred such models are negligible
HALF_PERIODS = round(2 * max(BENDS))  # columns of a smooth function


def word(probability: float) -> Confidence:
    """Return the word for the probability of a cause."""
    if probability >= ESTABLISHED:
        return "established"
    return "likely" if probability >= LIKELY else "possible"
