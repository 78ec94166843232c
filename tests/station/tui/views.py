"""Views made by hand: a campaign as a technician sees it. Tests and screenshots show them."""

from drivers.errors import LinkSilent
from station.guide.setup_view import Choice
from station.guide.stages.guide import trouble_of
from station.guide.view import (
    CalibrationView,
    FilterView,
    GatesView,
    LimitView,
    LinkView,
    MonitoredView,
    OperatorQuestion,
    SoakView,
    StepView,
    TurnView,
    Verdict,
    VerdictRow,
    WarmUpView,
)
from station.stream.connected_unit import UnitChanged
from tests.station.tui import start_views
from tests.station.tui.campaign_under_way import EVENTS, LINK, UNIT, pose, running, steps
from tests.station.tui.start_views import FOLDER

CONNECTING = CalibrationView(
    stage="connecting", line="connecting", hint="waiting for the unit's model and serial number",
    folder=FOLDER, link=LinkView(name="ttyUSB0"),
)  # fmt: skip
WARMING = running(
    "warm_up",
    steps=steps(0), wanted="dwell_01", can_redo="", events=EVENTS[1:2], remaining_s=2700.0,
    line="leave the cube at rest on the surface plate",
    warm_up=WarmUpView(
        seconds=241.0, left_s=372.0, temperature_rate_c_min=0.21, temperature_limit_c_min=0.05,
        gyro_drift_deg_h=4.35e-14, gyro_limit_deg_h=0.0285235,
        note="waiting until the temperature rate is below 0.050 °C/min, now 0.210 °C/min",
    ),
)  # fmt: skip
PLACEMENT = running(
    "place",
    line="put the cube in position 3: X down, Y north, Z east",
    hint="waiting for stillness: gyro z moves",
    gates=GatesView(face="y_up", off_deg=40.0, still=38.2, still_channel="gyro z", heading="not known"),
    pose=pose(5, 25.0, 40.0, text="tip it over to the north: X down"),
)
UNKNOWN = PLACEMENT.model_copy(
    update={"pose": pose(3, std=None, text="its heading is not known yet"), "hint": "measuring the noise"}
)
WRONG_HEADING = PLACEMENT.model_copy(
    update={
        "hint": "X points down is correct, but the heading is wrong: turn 35 deg more, clockwise from above",
        "gates": GatesView(face="x_down", off_deg=0.3, is_right_face=True, still=1.1, still_channel="gyro z",
                       is_still=True, heading="not known"),
        "pose": pose(3, 35.0, turn_deg=-35.0, text="turn 35 deg more, clockwise from above"),
    }
)  # fmt: skip
TURN_IT = PLACEMENT.model_copy(
    update={
        "hint": "",
        "gates": WRONG_HEADING.gates,
        "pose": pose(3, 176.0, turn_deg=-176.0,
                     text="turn 176 deg more, clockwise from above; or leave it: position 4 is also still to do"),
    }
)  # fmt: skip
SETTLING = running(
    "settle",
    line="hands off: wait until the cube is at rest",
    hint="waiting for stillness: gyro z moves",
    pose=pose(3, text="the position is correct"),
    gates=GatesView(face="x_down", off_deg=0.31, is_right_face=True, still=7.9, still_channel="gz", position=3,
                heading="from the Earth rate"),
)  # fmt: skip
BADLY_SEATED = running(
    "settle",
    steps=steps(3), wanted="dwell_04",
    line="lift the cube, wipe it and the plate, set it down as before",
    hint="not seated: tilted by 84 arcsec along +y, limit 60",
    pose=pose(4, text="the position is correct"),
    gates=GatesView(face="x_down", off_deg=0.32, is_right_face=True, still=1.2, still_channel="gx", is_still=True,
                position=4, heading="from the Earth rate", is_seated=False,
                seating="not seated: tilted by 84 arcsec along +y, limit 60"),
)  # fmt: skip
HOLDING = running(
    "dwell",
    steps=steps(3, live="dwell_04"), live="dwell_04", wanted="dwell_04", accepted_s=62.0, wanted_s=100.0,
    remaining_s=2010.0,
    line="position 4: 62 of 100 s, hands off",
    pose=pose(4, text="the position is correct"),
    gates=GatesView(face="x_down", off_deg=0.32, is_right_face=True, still=1.1, still_channel="gx", is_still=True,
                position=4, heading="from the Earth rate", seating="seating error within 3 arcsec"),
)  # fmt: skip
DISTURBED = HOLDING.model_copy(
    update={
        "hint": "disturbed: the affected seconds are discarded; keep still",
        "gates": HOLDING.gates.model_copy(update={"still": 12.3, "is_still": False, "still_channel": "ay"}),
    }
)
FILLING = HOLDING.model_copy(
    update={
        "remaining_s": 330.0,
        "limits": (
            LimitView(text="gyroscope scale factor 2.13 of 3.00 ppm", share=1.0),
            LimitView(text="gyroscope bias 0.0268 of 0.0200 deg/h", share=0.56),
        ),
    }
)
TURNING = running(
    "turn",
    steps=steps(13, live="turn_x_minus"), live="turn_x_minus", wanted="turn_x_minus", remaining_s=310.0,
    line="turn X-: 2.34 of 3 turns", pose=pose(1, -122.0),
    turn=TurnView(revolutions=-2.34, speed_deg_s=-37.0),
)  # fmt: skip
CAME_BACK = TURNING.model_copy(
    update={
        "line": "hands off: the cube rests after turn X-",
        "pose": pose(1),
        "turn": TurnView(revolutions=-3.0, rest_s=3.0, is_back=True),
    }
)
ONES = (
    *(StepView(name=f"free_{n:02d}", state="done" if n < 3 else "todo", number=n, is_free=True, attempts=n < 3,
           seconds=100.0 * (n < 3)) for n in range(1, 13)),
    StepView(name="soak_01", state="todo", number=1, is_soak=True, position=9),
    StepView(name="soak_02", state="todo", number=2, is_soak=True, position=11),
)  # fmt: skip
TILTED = running(
    "place",
    steps=ONES,
    wanted="free_03",
    can_redo="free_02",
    events=EVENTS[:1],
    tilt=(1, 0, -1),
    line="tilt the cube on an edge, X half up, Z half down, near 45 deg; prop it",
    hint="12 deg from an attitude already recorded, at least 20: tilt it in another direction",
    gates=GatesView(
        face="y_up", off_deg=38.0, limit_deg=20.0, is_free=True, still=1.1, still_channel="gz", is_still=True
    ),
)
SOAKING = running(
    "dwell",
    steps=tuple(step.model_copy(update={"state": "live" if step.name == "soak_01" else "done"}) for step in ONES),
    live="soak_01", wanted="soak_01", can_redo="free_12", events=EVENTS[:1], accepted_s=1325.0, wanted_s=3600.0,
    remaining_s=5900.0,
    line="soak 1: 1325 of 3600 s, hands off; 31.4 degC (23.0 to 31.4 so far), 38 min left",
    soak=SoakView(temperature_c=31.4, low_c=23.0, high_c=31.4, left_s=2275.0),
    gates=GatesView(face="z_up", off_deg=0.3, is_right_face=True, still=1.1, still_channel="gz", is_still=True,
                position=9, heading="from the Earth rate"),
)  # fmt: skip
MONITORING = running(
    "dwell",
    steps=(
        *(StepView(name=f"dwell_{n:02d}", state="done", position=n, attempts=1, seconds=100.0)
          for n in range(1, 13)),
        StepView(name="monitor_01", state="live", number=1, is_monitor=True, position=9),
    ),
    live="monitor_01", wanted="monitor_01", can_redo="dwell_12", events=EVENTS[:1], accepted_s=41.0, wanted_s=60.0,
    remaining_s=19.0, line="monitor 1: 41 of 60 s, hands off",
    monitored=MonitoredView(
        filters=(
            FilterView(name="joint", roll_deg=0.0123, pitch_deg=-0.0041),
            FilterView(name="mixer", roll_deg=0.0131, pitch_deg=-0.0029),
        ),
        difference_deg=0.0014,
    ),
    gates=GatesView(face="z_up", off_deg=0.3, is_right_face=True, still=1.1, still_channel="gz", is_still=True,
                position=9, heading="from the Earth rate"),
)  # fmt: skip
PAUSED = running("paused", line="paused: nothing is recorded", hint="p goes on")
NOTHING = LinkSilent("ttyUSB0", 1.8, 921600)
OTHER = UnitChanged("ttyUSB0", "SIM-8", "SIM-7")
SILENT = HOLDING.model_copy(
    update={
        "link": LINK.model_copy(
            update={
                "is_live": False,
                "gaps": 1,
                "word": "NO DATA",
                "text": str(NOTHING),
            }
        ),
        "line": trouble_of(NOTHING)[1],
        "hint": str(NOTHING),
        "gates": None,
        "pose": None,
    }
)
OTHER_UNIT = SILENT.model_copy(
    update={
        "link": SILENT.link.model_copy(update={"word": "WRONG UNIT", "text": str(OTHER)}),
        "line": trouble_of(OTHER)[1],
        "hint": str(OTHER),
    }
)
ASKING = running(
    "settle",
    line="The heading cannot be told from the Earth rate here.",
    gates=SETTLING.gates,
    question=OperatorQuestion(
        text="X is down. Which way does +Y point?",
        choices=(
            Choice(key="3", title="north: position 3"),
            Choice(key="4", title="south: position 4"),
            Choice(key="o", title="neither", note="turn it to a mark first"),
        ),
    ),
)
REDOING = running("place", steps=steps(5, redo="dwell_02"), wanted="dwell_02", line="Position 2 again.")
SOLVING = running(
    "solving", steps=steps(18), wanted="", remaining_s=0.0, line="Solving 18 steps ...", hint="a few s"
)


def rows(what: str, unit: str, limit: str, *lines: str) -> tuple[VerdictRow, ...]:
    """Return the rows of x, y, z; a line holds value, sigma, change and, where there is a limit, the verdict."""
    cells = [[cell.strip() for cell in line.split("|")] for line in lines]
    return tuple(
        VerdictRow(name=f"{what} {axis}", value=value, sigma=sigma, expanded=f"{1.96 * float(sigma):.2g}",
            unit=unit, limit=limit if verdict else "", change=change, verdict=verdict)
        for axis, (value, sigma, change, verdict) in zip("xyz", cells, strict=True)
    )  # fmt: skip


ROWS = (
    *rows("accelerometer scale factor", "count/(g s)", "1000 to 1040",
          "1020.0132 | 0.0021 | +0.4 ppm | PASS", "1015.0087 | 0.0021 | -1.1 ppm | PASS",
          "1018.0004 | 0.0021 | +0.2 ppm | PASS"),
    *rows("accelerometer bias", "ug", "-3000 to 3000",
          "1000.41 | 0.09 | +0.4 ug | PASS", "2000.02 | 0.09 | -0.1 ug | PASS", "999.87 | 0.09 | +0.6 ug | PASS"),
    *rows("gyroscope bias", "deg/h", "-0.1 to 0.1",
          "0.134 | 0.006 | +0.02 deg/h | FAIL", "-0.021 | 0.006 | | PASS", "0.003 | 0.006 | |"),
)  # fmt: skip
PASSED = running(
    "verdict",
    steps=steps(18), wanted="", remaining_s=0.0, line="All values are within the limits of SIM-FOG3.",
    verdict=Verdict(
        word="PASS", sentence="All values are within the limits of SIM-FOG3.", status="measured",
        status_reason="the certificate of CUBE-7 expired on 2026-02-01",
        worst_residual="position 7, accelerometer y: 2.1 sigma, limit 4.0",
        change="largest since 2026-08-03: accelerometer scale factor y, -1.1 ppm (1.4 sigma)",
        diagnosis="The residual is what noise leaves (p 0.43). No further error term was detected.",
        rows=tuple(row for row in ROWS if row.verdict != "FAIL"), report=f"{FOLDER}/report.html",
        solution=f"{FOLDER}/solution.json",
    ),
)  # fmt: skip
DOUBT = "do not use this result, record position 4 again: it was kept although the cube was tilted by 0.3 deg"
AMBIGUOUS = PASSED.model_copy(
    update={
        "verdict": PASSED.verdict.model_copy(
            update={
                "doubt": DOUBT,
                "sentence": f"PASS: {DOUBT}; {PASSED.verdict.sentence}",
                "redo": "dwell_04",
            }
        )
    }
)
FAILED = PASSED.model_copy(
    update={
        "verdict": PASSED.verdict.model_copy(
            update={
                "word": "FAIL", "sentence": "The gyroscope bias x is 0.134 deg/h, the limit is 0.1 deg/h.",
                "status": "calibrated", "status_reason": "", "rows": ROWS,
                "warnings": ("warm-up was skipped: sigmas are wider",),
            }
        )
    }
)  # fmt: skip
NOT_MEASURED = PASSED.model_copy(
    update={
        "verdict": PASSED.verdict.model_copy(
            update={
                "word": "NOT_MEASURED",
                "in_words": "NO LIMITS",
                "sentence": "NO LIMITS: no limits are stored for SIM-FOG3.",
                "change": "",
            }
        )
    }
)
STORED = PASSED.model_copy(
    update={
        "stage": "stored",
        "verdict": PASSED.verdict.model_copy(update={"stored_sha256": "9f2c41d07be85a6391aa0c" + 42 * "0"}),
    }
)
CANCELLED = CalibrationView(stage="cancelled", unit=UNIT, folder=FOLDER, line="The campaign was cancelled.")
LEFT = running("left", line="Left after 2 of 18 steps.")
BROKEN = running(
    "failed", line="The campaign stopped.", error="The disk is full: 0 bytes are free on /srv, 40 MB expected."
)

VIEWS = {
    name.lower(): view
    for name, view in [*vars(start_views).items(), *globals().items()]
    if isinstance(view, CalibrationView) and name != "RUNNING"
}  # fmt: skip
