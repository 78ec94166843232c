"""The thirty laws as a user who knows them would write them down: what a solve is worth that knows the law.

Its parameters are told to a thousandth, its coefficients are fitted with everything else. Written beside
`tests.benchmarks.discovering.laws`, of which `tests.benchmarks.discovery_used` plants the numpy.
"""

from collections.abc import Mapping

from procedures.effects.term.effect_of_term import Parameter, TermEffect
from tests.benchmarks.discovering.laws import Law

TOLD = 1e-3  # relative: between what a parameter is fitted
WAVES = "sin(2 * pi * {0} / P) & cos(2 * pi * {0} / P)"
# law: terms, the unit of a coefficient, parameters with their unit
FORMS: Mapping[str, tuple[str, str, Mapping[str, tuple[float, str]]]] = {
    "dead zone": ("u * exp(-(u / w)**4)", "1", {"w": (12.0, "deg/h")}),
    "lock-in": ("sign(u) * sqrt(max(0 * u**2, u**2 - w**2)) - u", "1", {"w": (6.0, "deg/h")}),
    "polarization": (WAVES.format("T"), "deg/s", {"P": (1.7, "K")}),
    "source warms up": ("u * exp(-t / tau)", "1", {"tau": (300.0, "s")}),
    "g squared": ("f**2", "deg/s/g^2", {}),
    "next g squared": ("f_2**2", "deg/s/g^2", {}),
    "rectified rate": ("omega_2**2", "s/deg", {}),
    "two rates": ("omega_2 * abs(omega_2)", "s/deg", {}),
    "range ends": ("min(w, max(0 * w - w, u)) - u", "1", {"w": (60.0, "deg/s")}),
    "counts lost": ("sign(u) * max(0 * w, abs(u) - w)", "1", {"w": (25.0, "deg/s")}),
    "fifth power": ("u**5", "s^4/deg^4", {}),
    "convection": ("f**2 * (1 - exp(-t_step / tau))", "deg/s/g^2", {"tau": (40.0, "s")}),
    "bias warms up": ("exp(-t / tau)", "deg/s", {"tau": (400.0, "s")}),
    "self-heating": ("lag(omega_norm**2, tau)", "s/deg", {"tau": (200.0, "s")}),
    "temperature times its rate": ("T * T_rate", "deg/s*min/K^2", {}),
    "g-sensitivity with temperature": ("T * f", "deg/s/g/K", {}),
    "cross g with temperature": ("T * f_2", "deg/s/g/K", {}),
    "Faraday with temperature": ("T * B", "deg/s/uT/K", {}),
    "pressure cycles": (WAVES.format("t"), "deg/s", {"P": (500.0, "s")}),
    "of the heading": ("north**2", "deg/s", {}),
    "hinge remembers": ("f_before", "1", {}),
    "cross-axis K": ("f_2**2", "1/g", {}),
    "bow of a converter": (WAVES.format("u"), "g", {"P": (0.4, "g")}),
    "stiction": ("tanh(u / w)", "g", {"w": (0.3, "g")}),
    "magnet of a torquer": ("B_2", "g/uT", {}),
    "scale ages": ("t * u", "1/s", {}),
    "glue creeps": ("log(1 + t_step / tau) * (f - f_before)", "1", {"tau": (3.0, "s")}),
    "scale with the rate of temperature": ("T_rate * u", "min/K", {}),
    "cross-axis with temperature": ("T * f_2", "1/K", {}),
    "a sag of the supply's sine": (WAVES.format("t"), "g", {"P": (450.0, "s")}),
}


def known(law: Law) -> TermEffect:
    """Return a law as an effect, of any size."""
    terms, unit, told = FORMS[law.name]
    parameters = {
        name: Parameter(of, value * (1 - TOLD), value * (1 + TOLD)) for name, (value, of) in told.items()
    }
    return TermEffect(f"{law.triad}.law", law.triad, tuple(terms.split(" & ")), unit, 1e6, "", parameters)
