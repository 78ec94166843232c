"""NovAtel RAWIMU, log 268: RAWIMUS's body after the long header; binary and as text.

Source: OEM7 manual, log RAWIMU (docs.novatel.com/OEM7/Content/SPAN_Logs/RAWIMU.htm). Like RAWIMUS it neither names
the IMU nor says its health.
"""

from drivers.wire.novatel_ascii import ascii_log
from drivers.wire.novatel_log import binary_log, table

MESSAGE = 268
FRAME = table(is_long=True, is_typed=False)

FORMAT = binary_log(
    "rawimu",
    MESSAGE,
    FRAME,
    "RAWIMU",
    # The body of RAWIMUS's example under the long header, made by `encode`: no public frame was found.
    bytes.fromhex(
        "aa44121c0c0100002800000000b4a1085d684d1d0000000000000000 a1080000 0090ac0371011e41 00fe5aea"
        "98c7a0133faad9fffb4b4300 c9b90400294309009397f0ff 07a7ffbd"
    ),
)
ASCII = ascii_log(
    FORMAT,
    MESSAGE,
    table(is_long=False, is_typed=False),
    # RAWIMUS's example under the long header, made by `encode`
    b"#RAWIMUA,COM1,0,0.0,FINESTEERING,2209,491612.253,00000000,0000,0;2209,491612.253587961,ea5afe00,"
    b"329303960,-2512321,4410363,309705,607017,-1009773*d94152f0",
    is_long=True,
)
