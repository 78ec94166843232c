"""The rows that a calibration depends on, by one hash for each: unit, limits, campaign, cube, slab, site."""

import json
from collections.abc import Callable, Iterable
from typing import Any

from sqlalchemy.orm import Session

from fixtures_db.hash_chain import canonical, digest
from fixtures_db.row_content import contents
from fixtures_db.schema import Base

Find = Callable[[str, str, Any], Iterable[tuple[str, str]]]  # table, column, value: keys and contents
OWNED = {  # by the campaign's column: the table that it names a row of, and the tables whose rows name that
    "cube_id": ("cubes", ("tolerance_items", "face_certificates", "cube_measurements")),
    "slab_id": ("slabs", ("slab_levels",)),
    "site_id": ("sites", ()),
}


def used_now(session: Session, model: str, serial: str, campaign_id: int | None) -> dict[str, str]:
    """Return the hashes as the database stands."""
    connection = session.connection()

    def find(table: str, column: str, value: Any) -> Iterable[tuple[str, str]]:
        rows = Base.metadata.tables[table]
        return contents(connection, rows, rows.columns[column] == value)

    return used_hashes(find, model, serial, campaign_id)


def used_hashes(find: Find, model: str, serial: str, campaign_id: int | None) -> dict[str, str]:
    """Return the SHA-256 over the rows of each kind, of a cube and a slab with all that was measured of them."""
    units = [row for row in find("imus", "serial", serial) if json.loads(row[1])["model"] == model]
    used = {"imu": units, "limits": list(find("imu_limits", "model", model))}
    campaigns = [] if campaign_id is None else list(find("campaigns", "id", campaign_id))
    for key, content in campaigns:
        used["campaign"] = [(key, content)]
        named = json.loads(content)
        for column, (table, parts) in OWNED.items():
            if (name := named.get(column)) is not None:
                owned = [row for part in parts for row in find(part, column, name)]
                used[column.removesuffix("_id")] = [*find(table, "id", name), *owned]
    return {kind: digest(canonical({"rows": sorted(list(row) for row in rows)})) for kind, rows in used.items()}
