"""NovAtel RAWIMUS, log 325: RAWIMUSX's older sister, without IMU type and error bit; binary and as text.

Source: OEM7 manual, log RAWIMUS (docs.novatel.com/OEM7/Content/SPAN_Logs/RAWIMUS.htm). Time, axis order and
CRC as RAWIMUSX. The meaning of the status word depends on the IMU, which the log does not name: a frame is
read as healthy whenever its time is one, so prefer RAWIMUSX where the receiver has it.
"""

from drivers.wire.novatel_ascii import ascii_log
from drivers.wire.novatel_log import binary_log, table

MESSAGE = 325
FRAME = table(is_long=False, is_typed=False)

FORMAT = binary_log(
    "rawimus",
    MESSAGE,
    FRAME,
    "RAWIMUS",
    # The manual's ASCII example (week 2209) in the binary layout; no public binary frame was found.
    bytes.fromhex(
        "aa4413284501a1085e684d1d a1080000 9b92ac0371011e41 00fe5aea"
        "98c7a013 3faad9ff fb4b4300 c9b90400 29430900 9397f0ff 0c2daf3a"
    ),
)
ASCII = ascii_log(
    FORMAT,
    MESSAGE,
    FRAME,
    b"%RAWIMUSA,2209,491612.254;2209,491612.253588,ea5afe00,329303960,-2512321,4410363,"
    b"309705,607017,-1009773*1fb76c28",  # the manual's example
    is_long=False,
)
