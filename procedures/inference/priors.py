"""Every chosen number of the inference, each with its reason. There is no other in this folder."""

import numpy as np

# Expected number of a campaign's error terms by name: about forty names, of which a unit on its bench shows
# between none and two. A term of the bench or the procedure is as likely as one of the instrument.
ODDS_NAMED = 0.01
# A cause that no catalogue holds is a tenth as frequent as one that it holds, over about twenty families: a name that does the same is preferred.
ODDS_NAMELESS = 0.002
# Where one coefficient of an effect acts another of it often does.
ODDS_ANOTHER = 0.3
# A row class is noisier than its samples say as rarely as a single name acts: counting noise is well known.
ODDS_NOISE = 0.01

# Amplitude of a named effect over the standard deviation that its table states: that number is of the largest units,
# of which good ones show a thousandth.
AMPLITUDE_NAMED = (0.001, 3.0)
# A scatter is stated by the procedure within a factor of ten.
AMPLITUDE_SCATTER = (0.1, 10.0)
# A nameless function, in sigmas of all rows together: from what nothing could see to a thousand.
AMPLITUDE_NAMELESS = (1.0, 1000.0)
# Wider noise: the standard deviation of what is added over the counting noise.
AMPLITUDE_NOISE = (0.1, 10.0)
AMPLITUDES = 25  # points of a logarithmic grid: neighbours differ by a third of a standard deviation at most

# Half periods over the range of its coordinate beyond which a smooth function's spectrum falls off as k^-4.
# None is so few that the function would be a straight line, which has a name.
BENDS = (3.0, 10.0)
HALF_PERIODS = 24  # columns of a smooth function: twice the largest of `BENDS`
FINER = 3  # points in each interval of a time constant's grid: a third of 0.5 in its logarithm moves nothing
THE_SAME = 0.995  # correlation from which columns of 10 sigmas differ by less than one
KEPT = 1e-4  # of a family's largest variance, below which a direction is a hundredth of its size

WINDOW = 7.0  # nats below the best model, beyond which all models together weigh less than one in a hundred
PARENTS = 5  # models of one size from which the next are grown
LARGEST = 8  # causes in a model

ESTABLISHED, LIKELY = 0.99, 0.9  # probability from which a cause is called so


def grid(bounds: tuple[float, float]) -> np.ndarray:
    """Return amplitudes (m,) of equal weight, evenly spread in the logarithm."""
    found: np.ndarray = np.geomspace(*bounds, AMPLITUDES)
    return found
