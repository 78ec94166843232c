"""For each command the lines whose wording is kept: those that need neither a device nor a campaign."""

from tests.station.commands.transcripts import Step
from tests.station.effect_examples import DEAD_ZONE, WARMING

LIMITS = """model = "FOG-3"
[[limit]]
parameter = "accelerometer.bias"
low = -0.002
high = 0.002
unit = "g"
guard_band = 1.64
[[limit]]
parameter = "residual.p_value"
low = 0.01
unit = "1"
"""
NO_RECORDING = ("s.csv", "t_s,roll_rad,pitch_rad\n" + "0.01,0.1,0.2\n" * 100)
TRUTH = 'serial = "U-21"\nlatitude_deg = 48.1\nheight_m = 519.0\n'
MEASURED = "--tilt-arcsec 1.5 -0.5 --sigma-arcsec 0.5 0.25 --by 'CMM 12'"
ON = "--on 2026-03-04"
FAULT = '[[fault]]\nkind = "lost"\nat_s = 1\n\n'  # the next stands in line 5
SCENARIO = 'format = "scenario/1"\n'


def changed(name: str, text: str, *changes: tuple[str, str], by: str) -> list[Step]:
    """Return a file with each change in turn, and the command line ``by`` that reads it."""
    steps: list[Step] = []
    for old, new in changes:
        assert old in text, old
        steps += [(name, text.replace(old, new)), by]
    return steps


LINES: dict[str, list[Step]] = {
    "demo": [("thesis.txt", "years of work"), "demo --out ."],
    "simulate": [
        *(f"simulate {each}" for each in (
            "--tcp 99999", "--control -1", "--gnss udp:99999", "--gnss udpto", "--gnss udpto:300.1.1.1:9999",
            "--transport pigeon", "--transport slcan --format stim300",
            "--transport udp_multicast --format counts",
            "--dbc frames.dbc", "--track nothere", "--scenario s.toml --example 3",
        )),
        *(step for text in ("x = 1", '[effects."no.such"]\nx = 1\n', "accel_k = [1, 2]")
          for step in (("truth.toml", text), "simulate --truth truth.toml")),
        *(step for text in ("t\n1\n", "t_s,e_m,n_m,u_m\n# none\n", "t,e,n,u\n0,0,0,0\n1,nan,0,0\n")
          for step in (("track.csv", text), "simulate --track track.csv")),
        *(step for text in ('[[fault]]\nkind = "x"\nat_s = 1\n', '[[fault]]\nkind = "babble"\nat_s = 1\n',
                            f"[[gnss_fault]]\n{FAULT}", "[gnss_fault]\n", "[[fault]\n")
          for step in (("faults.toml", FAULT + text), "simulate --faults faults.toml")),
        ("truth.toml", ""), ("effect.toml", DEAD_ZONE), "simulate --truth truth.toml --effect effect.toml",
        "simulate --example 7 --effect effect.toml",
        ("truth.toml", '[effects."gyroscope.dead_zone"]\nx = 1\n'),
        *changed("effect.toml", DEAD_ZONE, ("-u * exp(-(u / w)**4)", "rain"),
                 ("**4)", "**4) * north"), ("-u * exp(-(u / w)**4)", "u * exp(-(u / w)**4) / 0"),
                 by="simulate --truth truth.toml --effect effect.toml"),
        ("truth.toml", '[effects."gyroscope.dead_zone"]\nq = 1\n'), ("effect.toml", DEAD_ZONE),
        "simulate --truth truth.toml --effect effect.toml",
        ("imu", "mine"), "simulate --pty imu",
        *(step for text in (
            'format = "scenario/2"', f"{SCENARIO}sped = 2", f"{SCENARIO}[imu]\nport = 5",
            f"{SCENARIO}[[hands]]\ndo = 'fly'", f"{SCENARIO}[[hands]]\ndo = 'turn y + 1'",
            f"{SCENARIO}[[gnss_fault]]\nkind='jump'\nat_s=1", f"{SCENARIO}speed =\nseed = 1",
        ) for step in (("s.toml", text), "simulate --scenario s.toml")),
    ],
    "devices": [
        "devices --url camera:video0", "devices --url /dev/ttyNONE", "devices --url pigeon:///x",
        NO_RECORDING, "devices --url replay:s.csv",
    ],
    "record": [
        "record /dev/ttyNONE --out r", "record serial:///dev/ttyNONE?baud=x --out r",
        NO_RECORDING, "record replay:s.csv --out r", "record replay:s.csv?format=counts --fusion f",
        "record replay:nothere.mcap --out r", "record /dev/ttyNONE --fusion f", "record /dev/ttyNONE --out .",
    ],
    "plan": [
        "plan", "plan --limits FOG-9", "plan --noise nowhere", "plan --out x.json", "plan --continue begun",
        "plan --sigma gyroscope.bias=1deg/h --continue begun --minutes 9",
        *(f"plan --sigma {each}" for each in (
            "gyroscope.bias", "gyroscope.bais=0.02deg/h", "gyroscope=2deg/h", "gyroscope.bias=0.02ppm",
            "gyroscope.bias=-1deg/h", "accelerometer.bias=0.1", "gyroscope.bias=1e400deg/h",
        )),
    ],
    "calibrate": [
        "calibrate --plain", "calibrate --headless --device /dev/ttyNONE --latitude 31 --out c",
        "calibrate --plain --latitude 98 --device /dev/ttyNONE --out c", "calibrate --plan nothere.toml --plain",
        ("c.txt", ""), "calibrate --headless --device /dev/ttyNONE --latitude 31 --out .",
    ],
    "resume": ["resume", "resume nowhere", "resume --list"],
    "solve": ["solve", "solve nowhere", "solve .", ("campaign.toml", "[imu"), "solve ."],
    "diagnose": [
        "diagnose", "diagnose none.csv", "diagnose . --unit-gyro deg/s",
        ("log.csv", "t,ax\n" + "".join(f"{0.02 * i:.2f},{i % 3}\n" for i in range(40))),
        *(f"diagnose log.csv {each}" for each in (
            "", "--unit-gyro furlong", "--unit-time fortnight", "--as nap", "--as soak --as soak", "--time clock",
            "--as rate:z", "--as turn:+z --reference ax", "--accel wx,wy,wz", "--plan x.json",
        )),
        ("log.csv", "timestamp,ax\n" + "".join(f"{i},{i % 7}\n" for i in range(1000))), "diagnose log.csv",
        ("log.csv", "hello\nworld\n"), "diagnose log.csv",
    ],
    "effects": [
        "effects list", "effects show gyroscope.magic", "effects show gyroscope.magnetic",
        ("effect.toml", WARMING), "effects show effect.toml", "effects add effect.toml --model ' '",
        "effects add effect.toml --model FOG-3 --serial S1", "effects add effect.toml --model FOG-3 --serial S1",
        "effects list", "effects show gyroscope.warming_while_warm",
        "effects withdraw gyroscope.warming_while_warm --model FOG-3 --serial S1",
        "effects withdraw gyroscope.warming_while_warm --model FOG-3 --serial S1",
        *changed(
            "effect.toml", WARMING, ("T * T_rate", "T * humidity"), ("T * T_rate", "T.real"),
            ('"T * T_rate"', "[]"), ("deg/h/K/(K/min)", "deg/h/K"), ("deg/h/K/(K/min)", "deg/h/mile"),
            ("deg/h/K/(K/min)", "(h**12)**12"), ('"gyroscope"', '"magnetometer"'), ("= 1.0", "= 0"),
            ("= 1.0", '= 1.0\nsize = "x"'), ("warming_while_warm", "magnetic"), ("warming_while_warm", "../x"),
            ("T * T_rate", "T * 3 [deg/hr]"), ("effect/1", "effect/2"), ("T * T_rate", "T * T_rate\x00"),
            *(('source = "', f'shape.{each}\nsource = "') for each in (
                'tau = {unit = "s", low = 1}', 'tau = {unit = "s", low = 9, high = 1}',
                'tau = {unit = "s", low = 1, high = 9}', 'tau = {unit = "s", low = 9, high = 1, step = 2}',
                'w = {unit = "deg/hr", low = 1, high = 9}', 'T = {unit = "s", low = 1, high = 9}',
            )),
            by="effects show effect.toml",
        ),
        *(step for text in ("{", "[]", '{"format": "diagnosis/2", "findings": []}')
          for step in (("d.json", text), "effects adopt d.json --out law.toml")),
        "effects try effect.toml nowhere",
    ],
    "noise": [
        "noise nothere.csv",
        ("log.csv", "t_s,wx\n" + "".join(f"{i},{i % 3}\n" for i in range(30))), "noise log.csv",
        "noise log.csv --gyro wz",
        ("log.csv", "timestamp,wx\n" + "".join(f"{i},{i % 7}\n" for i in range(1000))), "noise log.csv",
        "noise log.csv --unit-time ns",
    ],
    "report": ["report nowhere", "report ."],
    "certificate": [
        "certificate", "certificate --example", "certificate SIM-7", ("lab.toml", 'format = "laboratory/1"\n'),
        "certificate SIM-7 --laboratory lab.toml", ("lab.toml", "name = "), "certificate S --laboratory lab.toml",
    ],
    "history": [
        "history", "history S1", "history S1 --population FOG-3", "history --population FOG-3",
        "history --population FOG-3 --at 2030-01-01",
    ],
    "resolve": ["resolve", "resolve --all", "resolve nowhere", "resolve nowhere --scheduler pigeon"],
    "apply": [
        ("log.csv", "t_s,gx,gy,gz\n0,1,2,3\n0.01,1,2,3\n"), "apply log.csv --out o.csv",
        "apply log.csv --calibration c.json --out o.csv", "apply log.csv --calibration S7 --out o.csv",
        ("c.json", "{}"), "apply log.csv --calibration c.json --out o.csv",
        ("c.json", '{"format": "solution/1"}'), "apply log.csv --calibration c.json --out o.csv",
    ],
    "stream": [
        "stream /dev/ttyNONE --to pigeon:1", "stream /dev/ttyNONE --to udp:here", "stream /dev/ttyNONE --frame up",
        "stream", "stream /dev/ttyNONE --nominal", "stream /dev/ttyNONE --axes x,y,z",
    ],
    "monitor": [
        NO_RECORDING, "monitor replay:s.csv --plain", "monitor replay:s.csv?format=counts --plain",
        "monitor /dev/ttyNONE --filter pigeon", "monitor /dev/ttyNONE --axes x,y,z",
        "monitor /dev/ttyNONE --plain",
        "monitor /dev/ttyNONE --alarm roll", "monitor /dev/ttyNONE --lever-arm 1;2 --locate",
    ],
    "attitude": [
        "attitude nothere.csv",
        ("log.csv", "t_s,p_rad_s,q_rad_s,r_rad_s,fx_m_s2,fy_m_s2,fz_m_s2\n"
         + "".join(f"{0.01 * i:.2f},0.001,0.002,-0.001,0.1,-0.2,-9.8\n" for i in range(200))),
        *(f"attitude log.csv {each}" for each in (
            "--aid gnss", "--aid compass", "--tau -1", "--k1 0.1", "--tau 5 --k1 0.1 --k2 0.1",
            "--aid airspeed-filter --tau 5", "--aid none --tau 1e-9", "--direction backwards",
            "--direction both --aid airspeed", "--direction both --aid none --tau 5",
            "--direction both --diagnose",
            "--out log.csv", "--axes x,y,-z", "--accel-convention down", "--unit-gyro furlong", "--time clock",
        )),
    ],
    "tune": ["tune nothere.csv", ("log.csv", "t_s,p_rad_s\n0,1\n"), "tune log.csv"],
    "export": [
        "export c.json --to px4", "export c.json --to pigeon",
        *(step for text in ("x", "[]", '{"format": "solution/1"}', '{"format": "calibration/1", "gyroscope": {}}')
          for step in (("c.json", text), "export c.json --to px4")),
        "export c.json --to px4 --nominal-gyro -1",
    ],
    "locate": ["locate nowhere", "locate .", ("fusion.toml", 'format = "fusion/2"\n'), "locate ."],
    "fixtures": [
        "fixtures list", "fixtures show cube P1", "fixtures show cube C9", "fixtures due",
        "fixtures add cube C7 --side-mm 400 --tolerance t1=0.04 --tolerance t8=0.02",
        f"fixtures add certificate C7 x_up {MEASURED} {ON} --due 2999-03-04", "fixtures add slab S1",
        f"fixtures add level S1 {MEASURED} {ON} --due 2026-03-04",
        f"fixtures add level S1 {MEASURED} --on 2026-02-04 --due 2026-02-04",
        "fixtures add site L1 --latitude 48.1 --gravity 9.8072914 --gravity-sigma 2e-7 --gravity-by 'survey 12' "
        "--due 2020-01-01",
        "fixtures add imu FOG-3 0117", "fixtures list", "fixtures show cube C7", "fixtures show slab S1",
        "fixtures show site L1", "fixtures show imu 0117", "fixtures due", "fixtures show imu S9",
        *(f"fixtures add {each}" for each in (
            "cube P1 --side-mm 400", "cube P2 --side-mm -1", "cube P2 --side-mm 400 --tolerance t1",
            "cube P2 --side-mm 400 --tolerance t99=1", f"certificate P1 top {MEASURED} {ON}",
            f"level S9 {MEASURED} {ON}", "site L2 --latitude 48 --gravity 9.8", "site L2 --latitude 98",
            "imu FOG-3 0117", f"level S1 {MEASURED} --on 2999-01-01",
            f"level S1 {MEASURED} --on 2025-05-02 --due 2025-05-01",
            "level S1 --tilt-arcsec 1 1 --sigma-arcsec 1 0 --by CMM --on 2025-05-02",
        )),
        "fixtures due --within -1", "fixtures list",  # what was refused changed nothing
        *(step for text in (
            'format = "fixtures/2"\n', '[[slab]]\nid = "S"\nweight = 3\n',
            '[[site]]\nid = "S"\nlatitude_deg = 91.0\n',
            '[[cube]]\nid = "P1"\nside_mm = 300.0\n',
            '[[tolerance]]\ncube_id = "X"\nitem = "t1"\nkind = "flatness"\nface = "A"\ntolerance_mm = 1\n',
        ) for step in (("a.toml", text), "fixtures import a.toml")),
        ("slab.csv", "id,due_date\nS9,tomorrow\n"), "fixtures import slab.csv",
        ("slab.csv", 'id\n"S9\n'), "fixtures import slab.csv", ("slabs.csv", "id\nS9\n"),
        "fixtures import slabs.csv",
        "fixtures import nothere", "fixtures limits", "fixtures limits FOG-4", "fixtures limits FOG-A --example",
        *changed(
            "limits.toml", LIMITS, ("FOG-3", "FOG-4"), ("accelerometer.bias", "accelerometer.bais"),
            ("low = -0.002", 'low = "x"'), ("guard_band", "guardband"),
            ("residual.p_value", "accelerometer.bias.y"),
            ('"1"', '"1"\n[[limit]]\nparameter = "accelerometer.bias.y"\nhigh = 1\nunit = "g"'),
            ("[[limit]]", "[limit]"), (LIMITS, ""), by="fixtures limits FOG-3 --import limits.toml",
        ),
        "fixtures limits", ("limits.toml", LIMITS), "fixtures limits FOG-3 --import limits.toml",
        "fixtures limits FOG-3",
        "fixtures limits --import limits.toml", "fixtures limits FOG-3 --import none",
        "fixtures example", ("unit.toml", "colour = 3\n"), "fixtures example --truth unit.toml",
        ("unit.toml", TRUTH), "fixtures example --truth unit.toml",
        ("unit.toml", TRUTH.replace("48.1", "47.1")), "fixtures example --truth unit.toml",
        "fixtures tolerance", "fixtures tolerance CUBE-99", "fixtures tolerance P1 --want-ug 0",
        "fixtures tolerance P1 --want-ug 1 --k2-ug 5 --cubes 2000", "fixtures tolerance P1 --unit no.json",
        ("items.toml", "side_mm = 400.0\n[tolerance_mm]\nt11 = 0.1\n"), "fixtures tolerance --items items.toml",
        "fixtures measure C7 nowhere",
    ],
    "reset-terminal": ["reset-terminal"],
    "verify": [
        "verify --db nothere.db", "fixtures list",
        "verify", "verify nowhere", "verify .", ("SHA256SUMS", "abc  x\n"), "verify .",
        ("SHA256SUMS", f"{'0' * 64}  ../x\n"), "verify .", "verify --anchor nothere",
        "verify --stamp http://localhost/",
        "verify --stamp localhost --write-anchor a", ("page.html", "<html></html>"), "verify page.html",
    ],
}  # fmt: skip
