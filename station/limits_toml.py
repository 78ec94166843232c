"""``limits.toml``: the limits of an IMU model as a file.

```toml
model = "FOG-3"
[[limit]]
parameter = "accelerometer.bias"    # all three axes; or accelerometer.bias.x
low = -0.002                        # low, high or both
high = 0.002
unit = "g"                          # as in solution/1
guard_band = 1.64                   # optional: times the value's own 1 sigma; 0 if not given
[[limit]]
parameter = "residual.p_value"
low = 0.01
unit = "1"
```
"""

from pathlib import Path
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fixtures_db.limits import Limit, each_axis
from station.campaign_folder.toml_text import line_of, read_tables, read_text_file
from station.errors import DataRefused


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class LimitTable(_Table):
    """``[[limit]]``."""

    parameter: str
    low: float | None = None
    high: float | None = None
    unit: str
    guard_band: float = 0.0

    @property
    def limit(self) -> Limit:
        """The limit that it says."""
        return Limit(self.parameter, self.low, self.high, self.unit, self.guard_band)

    @model_validator(mode="after")
    def _is_a_limit(self) -> Self:
        _ = self.limit
        return self


class LimitsTable(_Table):
    """The whole of a ``limits.toml``."""

    model: str
    limit: Annotated[list[LimitTable], Field(min_length=1)]


def read_limits(path: Path) -> tuple[str, tuple[Limit, ...]]:
    """Return the model of a ``limits.toml`` and its limits, one for each axis.

    Raises
    ------
    DataRefused
        With file and line, if it is none or limits a parameter twice.
    """
    tables, lines = read_tables(read_text_file(path), path, LimitsTable)
    limits = dict[str, Limit]()
    for index, table in enumerate(tables.limit):
        for one in each_axis(table.limit):
            if one.parameter in limits:
                line = line_of(("limit", index), lines)
                raise DataRefused(path, line, f"a second limit of {one.parameter}", "one limit of a parameter")
            limits[one.parameter] = one
    return tables.model, tuple(limits.values())
