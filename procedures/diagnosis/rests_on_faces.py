"""Rests on known faces at unknown headings, where a campaign has no positions, as the accelerometers see them.

To accelerometers a heading matters only through the slab's tilt, which the model holds within its range anyway:
each rest is taken at its face's first position. The gyroscopes' horizontal Earth rate does hang on the heading, so
their outputs are left out.
"""

from dataclasses import replace

from procedures.campaign.campaign import Campaign, DwellRecord
from procedures.frames import face_of

FIRST = {face_of(position): position for position in range(12, 0, -1)}


def faces_as_positions(campaign: Campaign) -> Campaign:
    """Return a campaign whose rests on known faces stand in positions, if it has no positions of its own."""
    on_face = [rest for rest in campaign.rests if rest.up is not None and rest.series.accel is not None]
    if campaign.dwells or not on_face:
        return campaign
    dwells = tuple(
        DwellRecord(rest.name, FIRST[rest.up], replace(rest.series, gyro=None))
        for rest in on_face
        if rest.up is not None
    )
    return replace(campaign, dwells=dwells, rests=tuple(rest for rest in campaign.rests if rest.up is None))
