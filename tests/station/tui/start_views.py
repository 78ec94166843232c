"""Views of the start screen made by hand: a form filled in, campaigns to go on with, what lacks."""

from station.files.campaign_setup import Setup
from station.guide.setup_view import Choice, PortCheck, Readiness, ReadyLine, StartView, UnfinishedCampaign
from station.guide.view import CalibrationView

FOLDER = "/srv/campaigns/2026-11-21_1240_SIM-7"
URL = "serial:///dev/ttyUSB0?baud=921600&format=counts"

NOT_READY = Readiness(
    lines=(
        ReadyLine(
            name="limits", state="lacks",
            text="no limits are stored for SIM-FOG3; `station fixtures limits SIM-FOG3 --example`",
        ),
        ReadyLine(name="operator", state="ready", text="M. Huber"),
        ReadyLine(name="cube", state="lacks", text="CUBE-7, its certificate expired on 2026-02-01"),
        ReadyLine(name="slab", state="ready", text="SLAB-2, certificate due 2027-02-01"),
        ReadyLine(
            name="site", state="note",
            text="no survey with this gravity is stored; name one in the laboratory file",
        ),
        ReadyLine(name="disk", state="ready", text="18210 MB free, about 140 MB needed"),
        ReadyLine(name="receiver", state="note", text="none: the clock of this computer is used"),
    ),
    can_pass=False, no_pass="no limits are stored for SIM-FOG3",
    can_certify=False, no_certificate="a measurement report: the certificate of cube CUBE-7 expired on 2026-02-01",
)  # fmt: skip

START = CalibrationView(
    stage="start",
    line="Choose the port, the cube and the slab, and begin.",
    start=StartView(
        setup=Setup(
            url=URL, cube="CUBE-7", slab="SLAB-2", latitude_deg=48.13725, longitude_deg=11.5755, height_m=520.0,
            gravity_m_s2=9.80722, gravity_std_m_s2=2e-5, operator="M. Huber",
        ),
        ports=(
            Choice(key=URL, title="/dev/ttyUSB0  FTDI USB-RS422 cable"),
            Choice(key="serial:///dev/ttyS0?baud=921600", title="/dev/ttyS0  16550A"),
        ),
        cubes=(
            Choice(key="CUBE-7", title="CUBE-7, side 400 mm", note="certificate expired on 2026-02-01",
                   warns=True),
            Choice(key="CUBE-8", title="CUBE-8, side 300 mm", note="certificate due 2027-11-22"),
        ),
        slabs=(Choice(key="SLAB-2", title="SLAB-2, granite, room 114"),),
        check=PortCheck(
            url=URL, is_good=True, format="counts", model="SIM-FOG3", serial="SIM-7", rate_hz=100.0, frames=200,
            noise="49 ug/rtHz",
        ),
        readiness=NOT_READY,
        unfinished=(
            UnfinishedCampaign(
                folder=FOLDER, title="campaign of 12:40, 7 of 18 done, SIM-FOG3 SIM-7",
                serial="SIM-7", done=7, state="free",
            ),
            UnfinishedCampaign(
                folder="/srv/b", title="campaign of 09:12, 3 of 18 done, FOG-A 0231",
                serial="0231", done=3, state="in use",
            ),
            UnfinishedCampaign(
                folder="/srv/c", title="campaign of yesterday, 17 of 18 done, FOG-A 0199",
                serial="0199", done=17, state="not here",
            ),
        ),
    ),
)  # fmt: skip
GNSS = "mavlink:udpin:0.0.0.0:14550"
WITH_RECEIVER = START.model_copy(
    update={
        "start": START.start.model_copy(
            update={
                "setup": START.start.setup.model_copy(
                    update={"gnss": GNSS, "latitude_deg": None, "longitude_deg": None, "height_m": 0.0}
                ),
                "receiver": PortCheck(
                    url=GNSS, is_good=True,
                    text="48.137251, 11.575498 deg, 568.3 m, u 1.2 m, height 2.1 m",
                ),
            }
        )
    }
)  # fmt: skip
FIRST_START = CalibrationView(stage="start", start=StartView())
REFUSED = START.model_copy(
    update={"start": START.start.model_copy(update={"refused": "ttyUSB0 is in use by another program: close it."})}
)
