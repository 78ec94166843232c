"""A calibrated sample as a datagram of 96 bytes, little-endian.

docs/how-to/streaming.md has the table and two readers.
Each field stands at a multiple of its own size, so that a C compiler lays a struct out the same way.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAGIC = b"FOG1"  # the layout's name; another layout has another

DATAGRAM = np.dtype([
    ("magic", "S4"),
    ("flags", "<u4"),         # bits, as docs/how-to/streaming.md lists them
    ("sequence", "<u8"),      # rises by 1 with each sample sent
    ("t_s", "<f8"),           # device time
    ("utc_s", "<f8"),         # since 1970-01-01; NaN: not known
    ("f_m_s2", "<f8", 3),     # specific force
    ("omega_rad_s", "<f8", 3),  # angular rate
    ("temperature_c", "<f8"),   # NaN: not known
    ("lost", "<u4"),          # samples that the device's counter misses before this one
    ("run", "<u4"),           # of the sender: another number is another beginning of ``sequence``
])  # fmt: skip


def datagrams(fields: Mapping[str, NDArray[Any]], run: int) -> list[bytes]:
    """Return the datagrams of n samples, ``fields`` (n,) or (n, 3) by their names in `DATAGRAM`."""
    n = len(fields["sequence"])
    rows = np.zeros(n, DATAGRAM)
    rows["magic"], rows["run"] = MAGIC, run
    for name, values in fields.items():
        rows[name] = values
    size, all_bytes = DATAGRAM.itemsize, rows.tobytes()
    return [all_bytes[at : at + size] for at in range(0, n * size, size)]
