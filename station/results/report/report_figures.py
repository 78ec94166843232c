"""The plots of a report: drawn when first asked for, and once for all reports of the same solution."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from markupsafe import Markup

from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.frames import TRIADS
from station.results.report.noise_figure import DwellNoise, allan_svg, longest_dwell_noise
from station.results.report.residual_plot import residual_svg


@dataclass(frozen=True, eq=False)
class ReportFigures:
    """What a report shows of a solution and its campaigns; a report that only adds a hash shows the same."""

    solution: Solution
    campaigns: Sequence[Campaign]

    @cached_property
    def noise(self) -> DwellNoise | None:
        """The noise of the longest dwell; None where none is long enough."""
        return longest_dwell_noise(self.campaigns, self.solution)

    @cached_property
    def allan(self) -> Markup:
        """Its Allan deviation as an ``<svg>`` element; empty where there is none."""
        return Markup(allan_svg(self.noise)) if self.noise is not None and self.noise.triads else Markup("")

    @cached_property
    def residuals(self) -> list[tuple[str, Markup]]:
        """Each triad that has residuals, and these as an ``<svg>`` element."""
        drawn = ((triad, residual_svg(triad, self.solution.residuals)) for triad in TRIADS)
        return [(triad, Markup(svg)) for triad, svg in drawn if svg]
