"""NovAtel RAWIMUX, log 1461: RAWIMUSX's body after the long header; binary and as text.

Source: OEM7 manual, log RAWIMUX (docs.novatel.com/OEM7/Content/SPAN_Logs/RAWIMUX.htm). 72 bytes a sample where
RAWIMUSX has 56: at 200 Hz 144 kbit/s.
"""

from drivers.wire.novatel_ascii import ascii_log
from drivers.wire.novatel_log import binary_log, table

MESSAGE = 1461
FRAME = table(is_long=True, is_typed=True)

FORMAT = binary_log(
    "rawimux",
    MESSAGE,
    FRAME,
    "RAWIMUX",
    # The manual's ASCII example below in the binary layout; no public binary frame was found.
    bytes.fromhex(
        "aa44121cb50500002800000081b4a108cd5b4f1d20000002c50da941 0429a108 00e0737070031e41 00fe57ea"
        "9427a213636ddbff91614400 afe6040031ed030073b7f1ff 262be4db"
    ),
)
ASCII = ascii_log(
    FORMAT,
    MESSAGE,
    table(is_long=False, is_typed=True),
    b"#RAWIMUXA,USB1,0,64.5,FINESTEERING,2209,491740.110,02000020,0dc5,16809;04,41,2209,491740.109817,ea57fe00,"
    b"329394068,-2396829,4481425,321199,257329,-936077*cf9c035d",  # the manual's example
    is_long=True,
)
