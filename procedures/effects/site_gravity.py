"""True gravity exceeds the stated one: more specific force along up.

One with the scale factors of all accelerometers. Plausible: 1e-3 m/s2, normal gravity's error over rough country.
"""

import numpy as np

from procedures.effects.effect import Columns, Effect, Excitation
from procedures.units import STANDARD_GRAVITY


def columns(excitation: Excitation) -> list[Columns]:
    """Return the vertical in every campaign [g per m/s2]; ``where`` numbers campaigns from 1."""
    up = excitation.f / np.linalg.norm(excitation.f, axis=1)[:, None]
    campaign = excitation.per_step("campaign")
    return [
        Columns(
            ("value",),
            accel=np.where(campaign == number, 1.0, 0.0)[:, None, None] * up[:, :, None] / STANDARD_GRAVITY,
            where={"campaign": int(number) + 1},
        )
        for number in np.unique(campaign)
    ]


EFFECT = Effect(
    name="site.gravity",
    unit="m/s^2",
    physics="value / 9.80665 along up",
    source="Yao, Hu, He 2018, eq. (1): the reference is local gravity",
    plausible=1e-3,
    columns=columns,
    separate_by="a gravimetric survey of the site, or the same unit at a surveyed one",
    is_held_at_prior=True,
)
