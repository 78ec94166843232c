"""Coefficients and errors as people read them: ug for g, arcsec for rad, ppm for pure numbers."""

ARCSEC = 206264.80624709636  # in a radian


def shown_unit(unit: str) -> tuple[float, str]:
    """Return by what a value in a file's ``unit`` is multiplied for people, and the unit it then has.

    An error in deg is shown in arcsec, deg/h as it is. Only what stands before the first ``/`` is changed: g/g^2
    becomes ug/g^2, 1/K ppm/K.
    """
    if unit == "deg":
        return 3600.0, "arcsec"
    head, slash, rest = unit.partition("/")
    scale, name = {"g": (1e6, "ug"), "rad": (ARCSEC, "arcsec"), "1": (1e6, "ppm"), "": (1e6, "ppm")}.get(
        head, (1.0, head)
    )
    return scale, f"{name}{slash}{rest}"
