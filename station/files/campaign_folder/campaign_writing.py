"""A campaign to a folder: ``campaign.toml`` and a data file per step."""

from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Fixture, MeasuredCube, RestRecord
from procedures.counts.sample_records import Series
from procedures.frames import AXES
from procedures.units import RAD_S_PER_DEG_H, STANDARD_GRAVITY
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, CampaignTable
from station.files.columns import TRIADS
from station.files.toml_writing import toml_text


def write_campaign(folder: Path, campaign: Campaign, sample_period_s: float, suffix: str = ".csv") -> None:
    """Write a campaign's steps and then its ``campaign.toml``; steps keep their names, their files get ``suffix``.

    Times are written to the nanosecond. A repeat of a step must have a name of its own.

    Raises
    ------
    CannotWrite
        If the folder cannot be written, or an MCAP file is there already.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tables = campaign_tables(campaign, sample_period_s, suffix)
    files = [step.file for step in tables.steps()]
    if len(set(files)) < len(files):
        raise ValueError("two steps of one name: each needs a file of its own")
    kinds = (campaign.dwells, campaign.rests, campaign.turns, campaign.sequences)
    for name, series in ((step.name, step.series) for kind in kinds for step in kind):
        write_series(folder / (Path(name).stem + suffix), series)
    write_tables(folder, tables)


def campaign_tables(campaign: Campaign, sample_period_s: float, suffix: str) -> CampaignTable:
    """Return a campaign as the tables of ``campaign.toml``."""
    sigma, site = campaign.sigma, campaign.site
    return CampaignTable.model_validate(
        {
            "format": "campaign/1",
            "imu": {
                "model": campaign.model,
                "serial": campaign.serial,
                "sample_period_s": sample_period_s,
                "output": "increments" if campaign.counts else "rate",
            },
            "site": {
                "latitude_deg": _degrees(site.latitude),
                "gravity_m_s2": site.gravity,
                "gravity_std_m_s2": site.gravity_std,
                "magnetic_enu_ut": None if site.magnetic is None else list(site.magnetic),
            },
            "procedure": {
                "heading_std_deg": _degrees(sigma.heading),
                "closure_std_deg": _degrees(sigma.closure),
                "unsettled_gyro_deg_h": sigma.unsettled_gyro / RAD_S_PER_DEG_H or None,
                "unsettled_accelerometer_g": sigma.unsettled_accelerometer / STANDARD_GRAVITY or None,
            },
            "fixture": _fixture(campaign.fixture),
            "dwell": [
                *(
                    {"position": d.position, "file": Path(d.name).stem + suffix, **_turn_on(d.turn_on)}
                    for d in campaign.dwells
                ),
                *({**_attitude(r), "file": Path(r.name).stem + suffix} for r in campaign.rests),
            ],
            "turn": [
                {
                    "axis": t.axis,
                    "direction": t.direction,
                    "revolutions": t.revolutions,
                    "start_position": t.start_position,
                    "file": Path(t.name).stem + suffix,
                    **_turn_on(t.turn_on),
                }
                for t in campaign.turns
            ],
            "sequence": [{"file": Path(s.name).stem + suffix} for s in campaign.sequences],
        }
    )


def _turn_on(number: int) -> dict[str, int]:
    return {"turn_on": number} if number > 1 else {}


def write_tables(folder: Path, tables: CampaignTable) -> None:
    """Write ``campaign.toml``: there whole or, after a kill, as it was before."""
    replace_file(folder / CAMPAIGN_TOML, toml_text(tables.model_dump(exclude_none=True)).encode())


def write_series(path: Path, series: Series) -> None:
    """Write a step's file, as its suffix says ``.csv`` or ``.mcap``."""
    if path.suffix == ".mcap":
        from station.files.mcap_files import write_step  # heavy: only for MCAP

        write_step(path, series)
    else:
        replace_file(path, _csv_text(series).encode())


def _csv_text(series: Series) -> str:
    names, columns = ["t_s"], [[repr(round(t, 9)) for t in series.t.tolist()]]
    for values, triad in ((series.gyro, TRIADS["gyro"]), (series.accel, TRIADS["accel"])):
        if values is not None:
            names += triad
            columns += [[repr(v) for v in column] for column in values.T.tolist()]
    if np.isfinite(series.temperature).any():
        names.append("temp_c")
        columns.append(_cells(series.temperature))
    for name, values in series.extra.items():
        names.append(name)
        columns.append(_cells(values))
    return "\n".join([",".join(names), *map(",".join, zip(*columns, strict=True)), ""])


def _cells(values: FloatArray) -> list[str]:
    return ["" if v != v else repr(v) for v in values.tolist()]


def _fixture(fixture: Fixture) -> dict[str, object]:
    axes = [int(i) for i in np.argmax(np.abs(fixture.C_sb), axis=1)]
    tables: dict[str, object] = {
        "imu_axes": [f"{'+' if fixture.C_sb[q, i] > 0 else '-'}{AXES[i]}" for q, i in enumerate(axes)],
        "face": [
            {"resting": name, "up_tilt_rad": c.up_tilt.tolist(), "covariance_rad2": c.covariance.tolist()}
            for name, c in fixture.faces.items()
        ],
    }
    if fixture.measured is not None:
        tables["measured"] = measured_table(fixture.measured)
    return tables if fixture.id is None else {"id": fixture.id, **tables}


def measured_table(measured: MeasuredCube) -> dict[str, object]:
    """Return ``[fixture.measured]``."""
    return {
        "names": list(measured.names),
        "value_rad": measured.value.tolist(),
        "covariance_rad2": measured.covariance.tolist(),
        "units": list(measured.units),
    }


def _attitude(rest: RestRecord) -> dict[str, str]:
    return {"attitude": "free"} if rest.up is None else {"up": rest.up}


def _degrees(angle: float) -> float:
    return float(np.degrees(angle))
