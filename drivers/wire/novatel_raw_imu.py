"""NovAtel's raw IMU logs, binary and as text: increments per IMU sample in the order Z, minus Y, X, with GPS time.

Sources: OEM7 manual, logs RAWIMU, RAWIMUS, RAWIMUX, RAWIMUSX (docs.novatel.com/OEM7/Content/SPAN_Logs/NAME.htm).
Asked for with ``log rawimusxb onnew``. The header's time is that of the log, the body's that of the sample. Device
time is GPS seconds since 1980-01-06, so that it rises over a change of week. There is no frame counter and no
temperature. RAWIMU and RAWIMUS neither name the IMU nor have an error bit, and what their status word means
depends on the IMU: a frame is read as healthy whenever its time is one, so prefer the X logs where there are any.
RAWIMUX takes 72 bytes a sample where RAWIMUSX has 56: at 200 Hz 144 kbit/s.
"""

from drivers.wire._format import WireFormat
from drivers.wire.novatel_ascii import ascii_log
from drivers.wire.novatel_log import binary_log


def _both(
    name: str, message: int, binary: str, text: bytes, *, is_long: bool, is_typed: bool
) -> tuple[WireFormat, WireFormat]:
    """Return a log's binary form and its text form; ``binary`` [hexadecimal] and ``text`` are examples."""
    form = binary_log(name, message, bytes.fromhex(binary), is_long=is_long, is_typed=is_typed)
    return form, ascii_log(form, message, text, is_long=is_long, is_typed=is_typed)


_LOGS = (
    _both(
        "rawimusx", 1462, is_long=False, is_typed=True,
        # novatel_edie (MIT), python/test/test_decode_encode.py
        binary="aa441328b6059c0678b9e21c 000b9c06 0b9755a832941d41 03158000"
               "ebd09102 a687f3ff 38eafcff 66b7fcff 1c5fffff 59d9ffff 475fafba",
        # the same sample, same source
        text=b"%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,"
             b"43110635,-817242,-202184,-215194,-41188,-9895*a5db8c7b",
    ),
    _both(
        "rawimus", 325, is_long=False, is_typed=False,
        # The manual's ASCII example (week 2209) in the binary layout; no public binary frame was found.
        binary="aa4413284501a1085e684d1d a1080000 9b92ac0371011e41 00fe5aea"
               "98c7a013 3faad9ff fb4b4300 c9b90400 29430900 9397f0ff 0c2daf3a",
        text=b"%RAWIMUSA,2209,491612.254;2209,491612.253588,ea5afe00,329303960,-2512321,4410363,"
             b"309705,607017,-1009773*1fb76c28",  # the manual's example
    ),
    _both(
        "rawimux", 1461, is_long=True, is_typed=True,
        # The manual's ASCII example below in the binary layout; no public binary frame was found.
        binary="aa44121cb50500002800000081b4a108cd5b4f1d20000002c50da941 0429a108 00e0737070031e41 00fe57ea"
               "9427a213636ddbff91614400 afe6040031ed030073b7f1ff 262be4db",
        text=b"#RAWIMUXA,USB1,0,64.5,FINESTEERING,2209,491740.110,02000020,0dc5,16809;04,41,2209,491740.109817,"
             b"ea57fe00,329394068,-2396829,4481425,321199,257329,-936077*cf9c035d",  # the manual's example
    ),
    _both(
        "rawimu", 268, is_long=True, is_typed=False,
        # RAWIMUS's example under the long header, made by `encode`: no public frame was found.
        binary="aa44121c0c0100002800000000b4a1085d684d1d0000000000000000 a1080000 0090ac0371011e41 00fe5aea"
               "98c7a0133faad9fffb4b4300 c9b90400294309009397f0ff 07a7ffbd",
        text=b"#RAWIMUA,COM1,0,0.0,FINESTEERING,2209,491612.253,00000000,0000,0;2209,491612.253587961,ea5afe00,"
             b"329303960,-2512321,4410363,309705,607017,-1009773*d94152f0",
    ),
)  # fmt: skip
FORMATS = (*(binary for binary, _ in _LOGS), *(text for _, text in _LOGS))
