"""The datasheets' scale factors, written out a second time: in decimals, from the documents, not from the code."""

import pytest

from drivers.wire import FORMATS

# OEM7 manual, RAWIMUSX: rad and m/s per count; a foot is 0.3048 m, an arcsecond 4.84813681109536e-6 rad
FEET_27, FEET_26 = 0.3048 * 7.450580596923828125e-9, 0.3048 * 1.490116119384765625e-8
KVH = (4.84813681109536e-6 * 0.000390625, 1.52587890625e-6)  # 0.1 / 256 arcsec; 0.05 / 32768
NOVATEL = {
    "HG1700 AG11": (1.16415321826934814453125e-10, FEET_27, 100),
    "HG1700 AG58": (1.16415321826934814453125e-10, FEET_27, 100),
    "HG1700 AG17": (1.16415321826934814453125e-10, FEET_26, 100),
    "HG1700 AG62": (1.16415321826934814453125e-10, FEET_26, 100),
    "HG1900 CA29": (1.16415321826934814453125e-10, FEET_27, 100),
    "HG1900 CA50": (1.16415321826934814453125e-10, FEET_27, 100),
    "HG1930 AA99": (1.16415321826934814453125e-10, FEET_27, 100),
    "HG1930 CA50": (1.16415321826934814453125e-10, FEET_27, 100),
    "HG4930 AN01": (1.16415321826934814453125e-10, 1.862645149230957e-9, 100),
    "HG4930 AN04": (1.16415321826934814453125e-10, 1.862645149230957e-9, 100),
    "HG4930 AN04 400 Hz": (1.16415321826934814453125e-10, 1.862645149230957e-9, 400),
    "LN-200": (1.9073486328125e-6, 6.103515625e-5, 200),
    "iMAR FSAS": (*KVH, 200),
    "KVH COTS": (*KVH, 200),
    "KVH 1750": (*KVH, 200),
    "ISA-100C": (0.000000001, 0.00000002, 200),
    "LITEF uIMU-IC": (0.000000001, 0.00000002, 200),
    # 720 / 2147483648 = 3.3527612686157227e-7 deg, 200 / 2147483648 m/s
    "ADIS16488": (5.851672317068635e-9, 9.313225746154785e-8, 200),
    # 1 / 2097152 deg = 0.4768371582 udeg, 1 / 4194304 m/s
    "STIM300": (8.322378406497613e-9, 2.384185791015625e-7, 125),
    "STIM300D": (8.322378406497613e-9, 2.384185791015625e-7, 125),
    # (0.008 / 65536) deg/s and (0.2 / 65536) mg, 0.0151515 and 0.4 of the G370, over the output rate
    "Epson EG320N": (1.7044230976507e-11, 2.3942016601562e-10, 125),
    "Epson EG320N 200 Hz": (1.0652644360317e-11, 1.4963760375977e-10, 200),
    "Epson EG370N": (2.0175442628168e-11, 2.9927520751953e-10, 200),
}
STIM300 = {  # TS1524, incremental angle and velocity: 2^-21 deg; m/s by the accelerometers' range
    "STIM300 5 g": 1.1920928955078125e-7,
    "STIM300 10 g": 2.384185791015625e-7,
    "STIM300 30 g": 4.76837158203125e-7,
    "STIM300 80 g": 1.9073486328125e-6,
}


@pytest.mark.parametrize("name", [name for name in FORMATS if name.startswith("rawimu")])
def test_novatel_logs_hold_the_manuals_scale_factors(name: str) -> None:
    scales = FORMATS[name].scales
    assert scales.keys() == NOVATEL.keys()
    for model, (gyro, accel, rate) in NOVATEL.items():
        assert scales[model].gyro == pytest.approx(gyro, rel=1e-12), model
        assert scales[model].accel == pytest.approx(accel, rel=1e-12), model
        assert scales[model].rate_hz == rate, model


def test_the_stim300_holds_its_datasheets_scale_factors() -> None:
    scales = FORMATS["stim300"].scales
    assert scales.keys() == STIM300.keys()
    for model, accel in STIM300.items():
        assert scales[model].accel == pytest.approx(accel, rel=1e-12), model
        assert scales[model].gyro == pytest.approx(8.322378406497613e-9, rel=1e-12), model


def test_the_ch70_holds_its_test_reports_scale_factor() -> None:
    (scale,) = FORMATS["ch70"].scales.values()
    runs = (47014.47, 47023.17, 47019.32)  # count/(deg/s), unit 19036
    assert 1 / (scale.gyro * scale.rate_hz * 57.29577951308232) == pytest.approx(sum(runs) / 3, rel=1e-6)
    assert scale.rate_hz == 400
