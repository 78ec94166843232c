"""The set-up of a guided campaign, as it is remembered and kept in its folder."""

from pydantic import BaseModel, ConfigDict


class Setup(BaseModel):
    """The set-up's values, remembered for next time; empty text and None where nothing is chosen yet.

    ``gravity`` and its sigma in m/s2, ``height`` in m, ``dwell_s`` 0: from the unit's noise and ``bias_ug``, the
    1 sigma wanted of the accelerometers' bias. ``repeats``: how often the first position is recorded
    again at the end. ``folder`` empty: one is made beneath the default place. ``gnss``
    is a receiver's address: what it says of the site counts where latitude, longitude or height are not given.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    url: str = ""
    gnss: str = ""
    model: str = ""
    serial: str = ""
    cube: str = ""
    slab: str = ""
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    height_m: float = 0.0
    gravity_m_s2: float | None = None
    gravity_std_m_s2: float | None = None
    operator: str = ""
    dwell_s: float = 100.0
    bias_ug: float | None = None
    revolutions: int = 3
    repeats: int = 1
    heading_std_deg: float = 0.1
    closure_std_deg: float = 0.02
    folder: str = ""
