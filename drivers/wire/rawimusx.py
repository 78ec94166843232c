"""NovAtel RAWIMUSX, log 1462: raw IMU counts with GPS time, short header, binary and as text.

Source: OEM7 manual, log RAWIMUSX (docs.novatel.com/OEM7/Content/SPAN_Logs/RAWIMUSX.htm). Asked for with
``log rawimusxb onnew``. Counts are increments per IMU sample in the order Z, minus Y, X. The header's time
is that of the log, the body's that of the sample. Device time is GPS seconds since 1980-01-06, so that it
rises over a change of week. There is no frame counter and no temperature.
"""

from drivers.wire.novatel_ascii import ascii_log
from drivers.wire.novatel_log import binary_log, table

MESSAGE = 1462
FRAME = table(is_long=False, is_typed=True)

FORMAT = binary_log(
    "rawimusx",
    MESSAGE,
    FRAME,
    "RAWIMUSX",
    # novatel_edie (MIT), python/test/test_decode_encode.py
    bytes.fromhex(
        "aa441328b6059c0678b9e21c 000b9c06 0b9755a832941d41 03158000"
        "ebd09102 a687f3ff 38eafcff 66b7fcff 1c5fffff 59d9ffff 475fafba"
    ),
)
ASCII = ascii_log(
    FORMAT,
    MESSAGE,
    FRAME,
    # the same sample, same source
    b"%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,"
    b"43110635,-817242,-202184,-215194,-41188,-9895*a5db8c7b",
    is_long=False,
)
