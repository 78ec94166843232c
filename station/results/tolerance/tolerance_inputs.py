"""A cube's tolerance items, from the database or from a file, and the unit they are judged with.

```toml
side_mm = 400.0
[tolerance_mm]          # Yao 2018 table 2; all eleven
t1 = 0.04
t4-1 = 0.04
# ...
[cost]                  # optional: an item costs its weight over its tolerance; 1 where not given
t3 = 2.0
[set_aside]             # optional: what Yao 2018 sets aside, docs/explanation/tolerance.md; default: usual sizes
slab-flatness = 0.008
[campaign]              # optional: what they act in
seat_side_mm = 200.0    # half the cube's side where not given
latitude_deg = 45.0
turn_s = 60.0
```
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from drivers.simulated.truth import paper_truth
from fixtures_db.database import open_db
from fixtures_db.fixtures import fixture_row
from fixtures_db.schema import CubeRow
from procedures.arrays import FloatArray
from procedures.tolerance.drawing_items import ITEMS, angles
from procedures.tolerance.estimator_errors import ToleranceUnit
from procedures.tolerance.neglected_effects import SET_ASIDE
from station.errors import DataRefused
from station.files.toml_file import read_tables, read_text_file

LARGEST_ANGLE = 0.1  # rad
USUAL = {name: item.size for name, item in SET_ASIDE.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """A cube's name, side [mm], items (11,) [rad] and the weights (11,) of their costs.

    ``set_aside``: size of every item of `SET_ASIDE`, in its own unit; ``campaign``: what they act in.
    """

    cube: str
    side_mm: float
    item: FloatArray
    weight: FloatArray
    set_aside: Mapping[str, float]
    campaign: "CampaignTable"


class CampaignTable(BaseModel):
    """What the items that Yao 2018 sets aside act in."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    seat_side_mm: float | None = Field(default=None, gt=0, le=1e5)
    latitude_deg: float = Field(default=45.0, ge=-90, le=90)
    turn_s: float = Field(default=60.0, ge=1, le=1e5)


class ItemsTable(BaseModel):
    """The whole of an items file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    side_mm: float = Field(ge=1, le=1e5)
    tolerance_mm: dict[str, float]
    cost: dict[str, float] = {}
    set_aside: dict[str, float] = {}
    campaign: CampaignTable = CampaignTable()


def drawing_of_file(path: Path) -> Drawing:
    """Return the drawing that a file gives; raise `DataRefused` if it is none."""
    table, _ = read_tables(read_text_file(path), path, ItemsTable)
    if wrong := [f"{item} = {weight}" for item, weight in table.cost.items() if item not in ITEMS or weight <= 0]:
        raise DataRefused(path, None, f"cost {', '.join(wrong)}", f"weights above zero of {', '.join(ITEMS)}")
    weight = np.array([table.cost.get(item, 1.0) for item in ITEMS])
    if wrong := [
        f"{item} = {size}" for item, size in table.set_aside.items() if item not in SET_ASIDE or size < 0
    ]:
        raise DataRefused(path, None, f"set_aside {', '.join(wrong)}", f"zero or more of {', '.join(SET_ASIDE)}")
    item = _angles(table.tolerance_mm, table.side_mm, path)
    return Drawing(path.stem, table.side_mm, item, weight, USUAL | table.set_aside, table.campaign)


def drawing_of_cube(db: str | None, name: str) -> Drawing:
    """Return the drawing of a cube in the database; `NotInDatabase`, or `DataRefused` if items are missing."""
    with open_db(db) as database, database.read() as session:
        row = fixture_row(session, CubeRow, name)
        side, items = row.side_mm, {t.item: t.tolerance_mm for t in row.tolerances}
    item = _angles(items, side, f"cube {name}")
    return Drawing(name, side, item, np.ones(len(ITEMS)), USUAL, CampaignTable())


def paper_unit(K2: float) -> ToleranceUnit:
    """Return Yao 2018's unit (table 4) with the same ``K2`` [g/g^2] in every sensor."""
    truth = paper_truth()
    return ToleranceUnit(_rows(truth.accel_e), truth.accel_d_g, np.full(3, K2))


def unit_of_solution(path: Path, K2: float) -> ToleranceUnit:
    """Return the accelerometers of a ``solution/1``, the IMU's axes being the cube's; refuse what is none."""
    content = read_text_file(path)
    try:
        part = json.loads(content)["accelerometer"]
        E, D = np.array(part["misalignment"]["value"], float), np.array(part["bias"]["value"], float)
    except (ValueError, KeyError, TypeError) as error:
        is_other = error.args == ("accelerometer",)
        found = "a solution without accelerometers (its warnings say why)" if is_other else repr(error)
        raise DataRefused(path, None, found, "a solution/1 with accelerometers", "name another") from None
    if E.shape != (3, 3) or D.shape != (3,):
        raise DataRefused(path, None, f"shapes {E.shape}, {D.shape}", "E (3, 3) and D (3,)")
    return ToleranceUnit(_rows(E), D, np.full(3, K2))


def _rows(E: FloatArray) -> FloatArray:
    unit: FloatArray = E / np.linalg.norm(E, axis=1, keepdims=True)
    return unit


def _angles(items: Mapping[str, float], side_mm: float, where: Path | str) -> FloatArray:
    try:
        item = angles(items, side_mm)
    except ValueError as error:
        raise DataRefused(where, None, str(error), f"all of {', '.join(ITEMS)} in mm") from None
    if not item.all():
        raise DataRefused(where, None, "a tolerance of zero", "tolerances above zero")
    if not (abs(item) <= LARGEST_ANGLE).all():
        expected = f"tolerances above zero, at most {LARGEST_ANGLE:g} of the side: the errors are of small angles"
        raise DataRefused(
            where, None, f"a tolerance that is {item[np.argmax(abs(item))]:.3g} rad on the side", expected
        )
    return item
