"""The site's magnetic field from the World Magnetic Model, where a folder gives its longitude and no field.

The model (NOAA NCEI and BGS, a new one every five years) is right to about 0.15 uT for the Earth's core and crust;
the steel of a bench is not in it. Height above sea level is taken for that above the ellipsoid: 100 m are 2 nT.
"""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, date, datetime

import numpy as np

from station.files.campaign_folder.loaded_campaign import LoadedCampaign

FIRST = date(2010, 1, 1)  # of the oldest model that pygeomag holds; what counts from elsewhere is no date
HINT = "give site.magnetic_enu_ut"
UNKNOWN = "gyroscope.magnetic cannot be tested"


def with_magnetic_field(loaded: LoadedCampaign, today: date | None = None) -> LoadedCampaign:
    """Return a campaign with the field at its site [uT, East-North-Up], or with a warning that says why not.

    The day is that of its recordings; where no file knows it, ``today``.
    """
    site = loaded.tables.site
    if site is None or loaded.campaign.site.magnetic is not None or site.longitude_deg is None:
        return loaded
    if not any(step.data is not None and step.data.series.gyro is not None for step in loaded.steps):
        return loaded  # nothing that feels it
    recorded = recorded_on(loaded)
    day = recorded or today or datetime.now(UTC).date()
    try:
        field = world_magnetic_model(site.latitude_deg, site.longitude_deg, site.height_m, day)
    except ValueError:
        why = f"no installed World Magnetic Model is valid on {day}"
        return _warned(
            loaded, f"no site.magnetic_enu_ut, and {why}: {UNKNOWN}; {HINT}, or install a newer pygeomag"
        )
    campaign = replace(loaded.campaign, site=replace(loaded.campaign.site, magnetic=field))
    filled = replace(loaded, campaign=campaign)
    if recorded is not None:
        return filled
    return _warned(
        filled,
        f"no file states its date: the magnetic field is that of {day}, and changes by up to 0.2 uT a "
        f"year; {HINT} where that matters",
    )


def world_magnetic_model(
    latitude_deg: float, longitude_deg: float, height_m: float, day: date
) -> tuple[float, float, float]:
    """Return the field [uT], East-North-Up.

    Raises
    ------
    ValueError
        If no model that is installed holds on that day.

    Source: A. Chulliat et al., The US/UK World Magnetic Model for 2025-2030, NOAA NCEI 2025, and those before.
    """
    from pygeomag import GeoMag, calculate_decimal_year

    found = GeoMag(base_year=day.year).calculate(
        glat=latitude_deg, glon=longitude_deg, alt=height_m / 1000, time=calculate_decimal_year(day)
    )
    return float(found.y) / 1000, float(found.x) / 1000, -float(found.z) / 1000  # nT, north-east-down


def recorded_on(loaded: LoadedCampaign) -> date | None:
    """Return the day (UTC) of the first recording that knows it: by ``utc_s``, or the station's time in MCAP."""
    days = [day for seconds in _times(loaded) if (day := _day(seconds)) is not None]
    return min(days, default=None)


def _times(loaded: LoadedCampaign) -> Iterator[float]:
    for step in loaded.steps:
        if step.data is None:
            continue
        utc = step.data.series.extra.get("utc_s", np.empty(0))
        yield from utc[np.isfinite(utc)][:1].tolist()
        if step.data.host_span is not None:
            yield step.data.host_span[0] / 1e9


def _day(seconds: float) -> date | None:
    """Return the day of a time since 1970, None of one that counts from elsewhere."""
    try:
        day = datetime.fromtimestamp(seconds, UTC).date()
    except (ValueError, OverflowError, OSError):
        return None
    return day if day >= FIRST else None


def _warned(loaded: LoadedCampaign, text: str) -> LoadedCampaign:
    return replace(loaded, warnings=(*loaded.warnings, f"{loaded.folder / 'campaign.toml'}: {text}"))
