"""Turntables and soaks in memory: steps that a diagnosis uses and a solve does not."""

from collections.abc import Sequence

import numpy as np

from procedures.campaign.campaign import RateTable, SoakRecord
from station.files.campaign_folder.campaign_schema import SoakTable, TurntableTable
from station.files.campaign_folder.loaded_campaign import LoadedStep

GYROSCOPES = ("gx", "gy", "gz")


def rate_tables(steps: Sequence[LoadedStep]) -> tuple[RateTable, ...]:
    """Return the turntable steps."""
    return tuple(_rate_table(step, step.table) for step in steps if isinstance(step.table, TurntableTable))


def _rate_table(step: LoadedStep, table: TurntableTable) -> RateTable:
    reference = step.points["rate_ref_deg_s"]
    absent = np.full(len(reference), np.nan)
    output = np.stack([step.points.get(name, absent) for name in GYROSCOPES], axis=1)
    return RateTable(table.file, table.axis, reference, output, step.points.get("temp_c", absent))


def soaks(steps: Sequence[LoadedStep]) -> tuple[SoakRecord, ...]:
    """Return the soaks."""
    return tuple(
        SoakRecord(step.table.file, step.table.position or 0, step.table.up, step.data.series)
        for step in steps
        if isinstance(step.table, SoakTable) and step.data is not None
    )
