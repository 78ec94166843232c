"""You and Lee's figures drawn again: errors on their flight by gyros alone, forward speed, velocity filter."""

from collections.abc import Callable

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from procedures.arrays import FloatArray
from procedures.attitude.attitude_estimate import estimate
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_filter import ComplementaryFilter
from procedures.attitude.complementary_gains import Gains
from procedures.attitude.forward_right_down import roll_pitch_of
from tests.drivers.simulated.flight import LEVEL_S, paper_flight

SEED, RUNS = 1, 6
NO_PULL = Gains(1e-9, 0.0)  # the gyros alone
BLUE, ORANGE = "#1f5a96", "#c4611a"
Estimator = Callable[[AttitudeLog], FloatArray]


def gyro_alone(log: AttitudeLog) -> FloatArray:
    """Return the down vector by the gyros alone."""
    return ComplementaryFilter(NO_PULL).run(log)


def by(aid: str) -> Estimator:
    """Return an estimator by one of the station's aids."""
    return lambda log: estimate(log, aid).down


def draw_errors(title: str, *methods: tuple[str, Estimator]) -> Figure:
    """Draw the errors of some runs; panels side by side where there are several methods."""
    figure, panels = plt.subplots(
        1, len(methods), figsize=(7.2, 2.7), layout="constrained", sharey=True, squeeze=False
    )
    for axes, (name, run) in zip(panels[0], methods, strict=True):
        for seed in range(SEED, SEED + RUNS):
            log = paper_flight(seed)
            assert log.roll is not None
            assert log.pitch is not None
            roll, pitch = roll_pitch_of(run(log))
            every = slice(None, None, 50)
            for angle, truth, colour, label in (
                (roll, log.roll, BLUE, "roll"),
                (pitch, log.pitch, ORANGE, "pitch"),
            ):
                error = np.degrees(angle - truth)[every]
                axes.plot(log.t[every], error, color=colour, lw=0.9, label=label if seed == SEED else None)
        axes.axvspan(LEVEL_S, log.t[-1], color="#eeeeee", zorder=0)
        axes.set(xlabel="time [s]")
        axes.set_title(name, fontsize=8)
    panels[0][0].set_ylabel("error [deg]")
    panels[0][0].legend(loc="upper left")
    figure.suptitle(title, fontsize=9)
    return figure


def draw_gyro() -> Figure:
    """Draw the paper's figure 3."""
    return draw_errors(f"gyro alone, {RUNS} flights; shaded: the turn", ("", gyro_alone))


def draw_forward_speed() -> Figure:
    """Draw the paper's figure 4, and what remembering the angle of attack makes of it."""
    return draw_errors(
        f"forward speed, {RUNS} flights; shaded: the turn", ("paper-airspeed: eq. 10", by("paper-airspeed")),
        ("airspeed: gated, angle of attack remembered", by("airspeed")),
    )  # fmt: skip


def draw_filter() -> Figure:
    """Draw the paper's figure 5, and the Kalman filter."""
    return draw_errors(
        f"velocity filter, {RUNS} flights; shaded: the turn", ("paper-filter: eq. 11-14", by("paper-filter")),
        ("airspeed-filter: attitude, velocity and biases in one", by("airspeed-filter")),
    )  # fmt: skip


FIGURES: dict[str, Callable[[], Figure]] = {
    "attitude_gyro": draw_gyro, "attitude_forward_speed": draw_forward_speed, "attitude_filter": draw_filter,
}  # fmt: skip
