"""Coefficients and errors as people read them: ug for g, arcsec for rad, ppm for pure numbers."""

from procedures.units import ARCSEC_PER_DEG, ARCSEC_PER_RAD, PPM_PER_ONE, UG_PER_G


def shown_unit(unit: str) -> tuple[float, str]:
    """Return by what a value in a file's ``unit`` is multiplied for people, and the unit it then has.

    An error in deg is shown in arcsec, deg/h as it is. Only what stands before the first ``/`` is changed: g/g^2
    becomes ug/g^2, 1/K ppm/K.
    """
    if unit == "deg":
        return ARCSEC_PER_DEG, "arcsec"
    head, slash, rest = unit.partition("/")
    scale, name = {
        "g": (UG_PER_G, "ug"),
        "rad": (ARCSEC_PER_RAD, "arcsec"),
        "1": (PPM_PER_ONE, "ppm"),
        "": (PPM_PER_ONE, "ppm"),
    }.get(head, (1.0, head))
    return scale, f"{name}{slash}{rest}"
