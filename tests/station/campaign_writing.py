"""A campaign to a folder: ``campaign.toml`` and a data file per step."""

from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Fixture, RestRecord
from procedures.counts.sample_records import RateSeries, Series
from procedures.frames import AXES
from procedures.positions import ATTITUDES, POSITIONS
from procedures.units import RAD_PER_ARCSEC, RAD_S_PER_DEG_H, STANDARD_GRAVITY
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_schema import CampaignTable, measured_table
from station.files.campaign_folder.plan_file import write_tables
from station.files.mcap_files.schemas import COUNTS, COUNTS_TOPIC, MESSAGES, RATES, SCHEMA
from station.files.mcap_files.writer import new_channel, new_file
from station.files.tables.strict_csv import TRIADS


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
    kinds = (campaign.dwells, campaign.rests, campaign.turns, campaign.sequences, campaign.moves)
    for name, series in ((step.name, step.series) for kind in kinds for step in kind):
        path = folder / (Path(name).stem + suffix)
        if suffix == ".mcap":
            _write_mcap(path, series)
        else:
            replace_file(path, _csv_text(series).encode())
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
                "seat_std_arcsec": sigma.seat / RAD_PER_ARCSEC,
                "unsettled_accelerometer_g": sigma.unsettled_accelerometer / STANDARD_GRAVITY or None,
            },
            "fixture": _fixture(campaign.fixture),
            "dwell": [
                *(
                    {**_placed(d.position), "file": Path(d.name).stem + suffix, **_turn_on(d.turn_on)}
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
            "move": [
                {"from": m.before + suffix, "to": m.after + suffix, "file": m.name + suffix}
                for m in campaign.moves
            ],
            "sequence": [{"file": Path(s.name).stem + suffix} for s in campaign.sequences],
        }
    )


def _turn_on(number: int) -> dict[str, int]:
    return {"turn_on": number} if number > 1 else {}


def _write_mcap(path: Path, series: Series) -> None:
    """Write the messages of a step; the series' own time [s] stands for the host's too."""
    kind = RATES if isinstance(series, RateSeries) else COUNTS
    stream, writer = new_file(path)
    channel = new_channel(writer, COUNTS_TOPIC, kind, SCHEMA)
    for i, t in enumerate(np.rint(series.t * 1e9).astype(np.int64).tolist()):
        content = MESSAGES[kind](
            device_ns=t,
            host_ns=t,
            gyro=() if series.gyro is None else series.gyro[i].tolist(),
            accel=() if series.accel is None else series.accel[i].tolist(),
            temperature_c=series.temperature[i],
            aux={name: values[i] for name, values in series.extra.items() if values[i] == values[i]},
        ).SerializeToString()
        writer.add_message(channel, log_time=t, data=content, publish_time=t)
    writer.finish()  # type: ignore[no-untyped-call]
    stream.close()


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


def _placed(number: int) -> dict[str, object]:
    return {"position": number} if number <= len(POSITIONS) else {"axes": ATTITUDES[number - 1]}


def _attitude(rest: RestRecord) -> dict[str, str]:
    return {"attitude": "free"} if rest.up is None else {"up": rest.up}


def _degrees(angle: float) -> float:
    return float(np.degrees(angle))
