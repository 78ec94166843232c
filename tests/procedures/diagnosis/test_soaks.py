"""Recordings at rest: jump, drift, settling, random walk, temperature coefficient and turn-on bias."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.effects import EFFECTS, Stimulus, TriadInput
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Site, SoakRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.diagnose import diagnose
from procedures.inference.result import Diagnosis
from station.files.logs.log_campaign import LogOptions, campaign_of_logs
from station.files.logs.log_columns import ColumnOptions

SECONDS, RATE = 900.0, 10
ARW = 0.67 / 60  # deg/sqrt(s)
STEP = 0.03  # deg/s
TIME = np.arange(int(SECONDS * RATE)) / RATE


def diagnosed(folder: Path, of_y: FloatArray, seed: int = 1) -> Diagnosis:
    """Diagnose a soak of noise whose gyroscope y has ``of_y`` (n,) [deg/s] besides, read as a user's table is."""
    gyro = ARW * np.sqrt(RATE) * np.random.default_rng(seed).standard_normal((len(TIME), 3))
    gyro[:, 1] += of_y
    np.savetxt(folder / "log.csv", gyro, "%.9g", ",", header="gx,gy,gz", comments="")
    return diagnose([read_soaks([folder / "log.csv"], ColumnOptions(rate_hz=RATE, unit_gyro="deg/s"))])


def read_soaks(logs: list[Path], columns: ColumnOptions) -> Campaign:
    """Return logs of a unit at rest as ``station diagnose --as soak`` reads them."""
    return campaign_of_logs(logs, LogOptions(columns, ("soak",))).loaded.campaign


@pytest.mark.parametrize("at_s", [210.0])
def test_a_jump_is_found_where_and_as_large_as_it_was(tmp_path: Path, at_s: float) -> None:
    (finding,) = diagnosed(tmp_path, np.where(at_s < TIME, STEP, 0.0)).findings
    assert finding.effect == "gyroscope.jump"
    assert finding.coefficients == ("y",)
    assert finding.value[0] == pytest.approx(3600 * STEP, abs=3.5 * finding.std[0])
    assert finding.where["in"] == "log.csv"
    assert finding.where["after_s"] == pytest.approx(at_s, abs=15)


@pytest.mark.parametrize(
    ("effect", "of"),
    [
        ("gyroscope.bias_drift", lambda t: STEP * t / SECONDS),
        ("gyroscope.bias_settling", lambda t: 1.3 * STEP * np.exp(-t / 200)),
    ],
)
def test_a_drift_and_a_settling_are_named(
    tmp_path: Path, effect: str, of: Callable[[FloatArray], FloatArray]
) -> None:
    """No thermometer was read: a drift may be a temperature as well."""
    found = diagnosed(tmp_path, of(TIME))
    groups = [each.shares for each in (*found.findings, *found.unnamed)]
    assert any(effect in group or "a temperature that was not recorded, gyroscope" in group for group in groups)
    assert not [each for each in found.findings if each.effect != effect and each.probability > 0.9]


@pytest.mark.parametrize("seed", [0])
def test_a_walk_is_never_sure_to_be_anything_else(tmp_path: Path, seed: int) -> None:
    steps = np.random.default_rng(50 + seed).standard_normal(len(TIME))
    found = diagnosed(tmp_path, np.cumsum(steps) * STEP / np.sqrt(len(TIME)), seed)
    for each in found.findings:
        assert each.confidence == "possible"


def test_a_tilt_is_not_sure_to_be_a_jump_of_the_accelerometers(tmp_path: Path) -> None:
    """What changes across gravity alone may be the stand; what changes along it is the sensor."""
    noise = 1e-4 * np.sqrt(RATE) * np.random.default_rng(4).standard_normal((len(TIME), 3)) + [0.02, 0.01, 1.0]
    for axis, names in ((0, {"accelerometer.jump", "placement.tilt"}), (2, {"accelerometer.jump"})):
        table = noise.copy()
        table[TIME > 450, axis] += 1e-3
        np.savetxt(tmp_path / "log.csv", table, "%.9g", ",", header="ax,ay,az", comments="")
        columns = ColumnOptions(rate_hz=RATE, unit_accel="g")
        (finding,) = diagnose([read_soaks([tmp_path / "log.csv"], columns)]).findings
        assert {finding.effect, *finding.aliases} == names
        assert (finding.confidence == "established") == (len(names) == 1)


def test_a_tilt_of_a_unit_with_biases_is_no_jump(tmp_path: Path) -> None:
    """With a bias of 8 mg the outputs say where gravity is to 8 mrad: of 2 mrad 16 ug go along them, 20 sigmas."""
    up = np.array([[0.003, -0.002, 1.0], [0.005, -0.003, 1.0]])
    up /= np.linalg.norm(up, axis=1)[:, None]
    table = 3e-5 * np.random.default_rng(5).standard_normal((len(TIME), 3)) + [0.008, -0.006, 0.004]
    table += up[(TIME > 450).astype(int)]
    np.savetxt(tmp_path / "log.csv", table, "%.9g", ",", header="ax,ay,az", comments="")
    columns = ColumnOptions(rate_hz=RATE, unit_accel="g")
    (finding,) = diagnose([read_soaks([tmp_path / "log.csv"], columns)]).findings
    assert finding.effect == "placement.tilt"
    assert finding.probability > 0.5
    found = dict(zip(finding.coefficients, zip(finding.value, finding.std, strict=True), strict=True))
    assert abs(found["y"][0]) == pytest.approx(2e-3, abs=3 * found["y"][1])


def test_noise_has_none_of_them(tmp_path: Path) -> None:
    assert not diagnosed(tmp_path, 0 * TIME).findings


# A random walk of the bias


WALK_SECONDS, WALK_RATE, BLOCK_S = 2000, 10, 100.0
WHITE = 3e-3  # g, of a sample
WALK = 1e-3  # g in an hour's root


def soak(folder: Path, accel: FloatArray, *, temperature: FloatArray | None = None) -> Campaign:
    """Return samples (n, 3) [g] at rest, read as a user's table is."""
    columns, names = [accel], "ax,ay,az"
    if temperature is not None:
        columns, names = [accel, temperature[:, None]], f"{names},temperature"
    np.savetxt(folder / "log.csv", np.hstack(columns), "%.9g", ",", header=names, comments="")
    return read_soaks([folder / "log.csv"], ColumnOptions(rate_hz=WALK_RATE, unit_accel="g"))


def noise(seed: int) -> FloatArray:
    return WHITE * np.random.default_rng(seed).standard_normal((WALK_SECONDS * WALK_RATE, 3))


def at_rest(accel: FloatArray) -> Campaign:
    """Return the same without a table."""
    t = np.arange(1, len(accel) + 1) / WALK_RATE
    series = RateSeries(t, None, accel, np.full(len(t), 25.0), 1 / WALK_RATE)
    site = Site(0.8, 9.8, 0.02)
    scale, soaks = {"accelerometer": 1.0}, (SoakRecord("soak", 0, None, series),)
    return Campaign("m", "s", False, site, (), (), nominal_scale=scale, soaks=soaks)


NOISES = {  # of a bias, by coefficient: g, g in an hour's root
    "accelerometer.bias_instability": 2e-4, "accelerometer.acceleration_random_walk": WALK
}  # fmt: skip


@pytest.mark.parametrize("draws", [4, pytest.param(8, marks=pytest.mark.proof)])
@pytest.mark.parametrize("name", NOISES)
def test_noise_of_a_bias_is_named_and_its_coefficient_is_within_its_uncertainty(name: str, draws: int) -> None:
    """Draws of the simulator, which knows no covariance: it adds sines."""
    sigmas, named = list[float](), list[float]()
    t = (np.arange(WALK_SECONDS * WALK_RATE) + 0.5) / WALK_RATE
    for seed in range(draws):
        sizes = {"value": NOISES[name], "seed": float(seed)}
        seen = Stimulus(*np.zeros((3, 1, 3)), t[:, None], *np.zeros((3, 1, 1)), 0, np.zeros_like)
        added = EFFECTS[name].accel(seen, TriadInput(np.zeros((1, 3)), np.zeros(3)), sizes)
        found = diagnose([at_rest(0.1 * noise(seed) + added)])
        cause = next(each for each in (*found.findings, *found.unnamed) if name in each.shares)
        named.append(cause.shares[name])
        own = [each for each in found.findings if each.effect == name and "channel" not in each.where]
        sigmas += [float((each.value[0] - NOISES[name]) / each.std[0]) for each in own]
    assert np.median(named) > 0.5
    assert len(sigmas) >= draws / 2
    assert np.sqrt(np.mean(np.square(sigmas))) < 2.0
    assert abs(np.mean(sigmas)) < 1.2


def test_two_jumps_are_no_random_walk() -> None:
    accel, places = 0.1 * noise(1), (620.0, 1440.0)
    for seconds, size in zip(places, (2e-4, -1.2e-4), strict=True):
        accel[int(seconds * WALK_RATE) :, 2] += size
    found = diagnose([at_rest(accel)]).findings
    assert [each.effect for each in found] == ["accelerometer.jump"] * 2
    assert sorted(float(str(each.where["after_s"])) for each in found) == pytest.approx(places, abs=20)


def flicker(seconds: int, size: float, seed: int) -> FloatArray:
    """Return noise (n, 3) of the one-sided power ``size^2 / (pi f)`` at 1 Hz, by its spectrum (IEEE Std 952)."""
    draws = np.fft.rfft(np.random.default_rng(seed).standard_normal((2 * seconds, 3)), axis=0)
    power = np.append(0.0, size**2 / (np.pi * np.fft.rfftfreq(2 * seconds)[1:]))
    found: FloatArray = np.fft.irfft(draws * np.sqrt(power / 2)[:, None], 2 * seconds, axis=0)[:seconds]
    return found


def test_flicker_of_a_long_recording_is_all_of_its_noise() -> None:
    """Half of it moves faster than forty draws show: what these leave would be a scatter without a name."""
    size, seconds = 1e-5, 3 * 3600
    white = 2e-5 * np.random.default_rng(7).standard_normal((seconds, 3))
    t = np.arange(1.0, seconds + 1)
    series = RateSeries(t, None, white + flicker(seconds, size, 8), np.full(seconds, 25.0), 1.0)
    soaks = (SoakRecord("soak", 0, None, series),)
    site = Site(0.8, 9.8, 0.02)
    found = diagnose([Campaign("m", "s", False, site, (), (), nominal_scale={"accelerometer": 1.0}, soaks=soaks)])
    (finding,) = found.findings
    assert finding.effect == "accelerometer.bias_instability"
    assert finding.probability > 0.9
    assert finding.value[0] == pytest.approx(size, abs=3 * finding.std[0])
    assert not [each for each in found.unnamed if each.probability > 0.1]


def test_a_settling_while_the_unit_warms_is_no_parabola_of_its_temperature(tmp_path: Path) -> None:
    """Both fit: that of fewer coefficients has the name, or neither."""
    t = np.arange(3 * 3600.0)
    gyro = 0.3 * np.random.default_rng(9).standard_normal((len(t), 3))  # deg/h
    gyro += np.outer(np.exp(-t / 600), (3.0, -1.8, 0.9))
    table = np.column_stack((gyro, 30 - 8 * np.exp(-t / 1500)))
    np.savetxt(tmp_path / "log.csv", table, "%.9g", ",", header="gx,gy,gz,temperature", comments="")
    campaign = read_soaks([tmp_path / "log.csv"], ColumnOptions(rate_hz=1.0, unit_gyro="deg/h"))
    findings = {each.effect: each.probability for each in diagnose([campaign]).findings}
    assert findings.get("gyroscope.bias_temperature", 0.0) < 0.5
    assert findings["gyroscope.bias_settling"] > 0.5


# Several recordings at one temperature each


LEVEL_SECONDS, LEVEL_RATE = 400, 10
LEVEL_N = LEVEL_SECONDS * LEVEL_RATE
TEMPERATURES = (20.0, 50.0, -20.0, 35.0, 0.0)
SLOPE = np.array([10.0, -5.0, 2.0])  # deg/h/K
OFF = np.array([150.0, -220.0, 60.0, 90.0, -80.0])  # deg/h, as drawn at turn-on


def diagnosed_levels(
    folder: Path, biases: FloatArray, *, moved: bool = False, accel_z: FloatArray | None = None
) -> Diagnosis:
    """Diagnose a log for each of the gyroscopes' biases (m, 3) [deg/h], at an attitude of its own if ``moved``."""
    rng, files = np.random.default_rng(7), list[Path]()
    for i, bias in enumerate(biases):
        up = rng.standard_normal(3) if moved else np.array([0.02, -0.01, 1.0])
        earth = 15.04 * (rng.standard_normal(3) if moved else np.array([0.5, 0.5, 0.7]))
        gyro = (bias + earth / np.linalg.norm(earth) * 15.04) / 3600 + 0.035 * rng.standard_normal((LEVEL_N, 3))
        accel = up / np.linalg.norm(up) + 3e-4 * rng.standard_normal((LEVEL_N, 3))
        accel[:, 2] += 0.0 if accel_z is None else accel_z[i]
        temperature = TEMPERATURES[i] + 0.02 * rng.standard_normal(LEVEL_N)
        table = np.column_stack([gyro, accel, temperature])
        files.append(folder / f"log{i}.csv")
        np.savetxt(files[-1], table, "%.9g", ",", header="gx,gy,gz,ax,ay,az,T", comments="")
    columns = ColumnOptions(
        gyro=("gx", "gy", "gz"), accel=("ax", "ay", "az"), unit_gyro="deg/s", unit_accel="g", temperature="T",
        rate_hz=LEVEL_RATE,
    )  # fmt: skip
    return diagnose([read_soaks(files, columns)])


@pytest.mark.parametrize("moved", [True])
def test_a_slope_by_temperature_is_determined_by_rests_at_one_temperature_each(
    tmp_path: Path, moved: bool
) -> None:
    found = diagnosed_levels(tmp_path, np.outer(np.array(TEMPERATURES) - 25, SLOPE), moved=moved)
    (finding,) = found.findings
    assert finding.effect == "gyroscope.bias_temperature"
    assert np.all(np.abs(finding.value - SLOPE) < 4 * finding.std)
    assert np.all(finding.std < 0.3)
    (error,) = (each for each in found.errors if each.quantity == "gyroscope neighbouring soaks")
    assert error.held_out_before is not None
    assert error.held_out_after is not None
    assert error.held_out_after < 0.1 * error.held_out_before


def test_a_bias_that_is_new_at_each_turn_on_is_named_and_its_sigma_reported(tmp_path: Path) -> None:
    found = diagnosed_levels(tmp_path, np.stack([OFF, np.roll(OFF, 2), np.roll(OFF, 3)], axis=1))
    (finding,) = found.findings
    assert (finding.effect, finding.coefficients) == ("gyroscope.turn_on_bias", ("value",))
    assert finding.value[0] == pytest.approx(float(np.std(OFF, ddof=1)), rel=0.35)


def test_a_jump_between_two_rests_is_named(tmp_path: Path) -> None:
    found = diagnosed_levels(tmp_path, np.outer(np.arange(5) >= 2, [0.0, 100.0, 0.0]))
    (cause,) = (*found.findings, *found.unnamed)
    assert cause.shares["gyroscope.jump"] > 0.1


@pytest.mark.parametrize("moved", [True])
def test_rests_that_differ_by_their_attitude_alone_are_consistent(tmp_path: Path, moved: bool) -> None:
    found = diagnosed_levels(tmp_path, np.zeros((5, 3)), moved=moved)
    assert not found.findings
    assert found.verdict == "consistent"


# A bias that cycles


CYCLE_SECONDS, CYCLE, CYCLE_NOISE = 3600, 50e-6, 40e-6  # s, g, g of a sample
CYCLE_TIME = np.arange(CYCLE_SECONDS * WALK_RATE) / WALK_RATE


def cycling(folder: Path, period_s: float, temperature: FloatArray | None = None) -> Diagnosis:
    """Diagnose an hour whose accelerometer x follows a sine that begins with 0.7 rad."""
    accel = CYCLE_NOISE * np.random.default_rng(int(period_s)).standard_normal((len(CYCLE_TIME), 3)) + [0, 0, 1.0]
    accel[:, 0] += CYCLE * np.sin(2 * np.pi * CYCLE_TIME / period_s + 0.7)
    return diagnose([soak(folder, accel, temperature=temperature)])


@pytest.mark.parametrize(("period_s", "is_warming"), [(250.0, True), (1500.0, False)])
def test_a_bias_that_cycles_is_named_with_its_period(tmp_path: Path, period_s: float, is_warming: bool) -> None:
    warming = 25 + 3 * (1 - np.exp(-CYCLE_TIME / 1500)) if is_warming else None
    (finding,) = cycling(tmp_path, period_s, warming).findings
    assert finding.effect == "accelerometer.bias_cycle"
    assert finding.probability > 0.99
    at = dict(zip(finding.coefficients, zip(finding.value, finding.std, strict=True), strict=True))
    truth = {"x.sin": CYCLE * np.cos(0.7), "x.cos": CYCLE * np.sin(0.7), "period_s": period_s}
    assert at.keys() == truth.keys()
    for name, (value, std) in at.items():
        assert value == pytest.approx(truth[name], abs=4 * std)
        assert std < 0.03 * truth[name]


@pytest.mark.parametrize("period_s", [60.0, 100.0])
def test_a_line_slower_than_a_block_is_named_with_its_frequency(tmp_path: Path, period_s: float) -> None:
    """One cycle in each block of the soak, or in one and a half of them, is no other cycle and no walk."""
    found = cycling(tmp_path, period_s)
    (finding,) = found.findings
    assert (finding.effect, finding.coefficients) == ("disturbance.line", ("ax.cos1", "ax.sin1"))
    assert not found.unnamed
    hertz, _, std, _ = finding.shape.split(" ", 3)
    assert float(hertz) == pytest.approx(1 / period_s, abs=4 * float(std))
    assert np.hypot(*finding.value) == pytest.approx(
        CYCLE, abs=4 * np.sqrt(2 / len(CYCLE_TIME)) * CYCLE_NOISE * 1.3
    )
    for value, std_of, true in zip(finding.value, finding.std, (np.sin(0.7), np.cos(0.7)), strict=True):
        assert value == pytest.approx(CYCLE * true, abs=4 * std_of)
    (error,) = (each for each in found.errors if each.quantity == "accelerometer samples")
    assert error.before == pytest.approx(1e6 * np.hypot(CYCLE_NOISE, CYCLE / np.sqrt(2)), rel=0.02)
    assert error.after == pytest.approx(1e6 * CYCLE_NOISE, rel=0.02)


def test_a_bias_that_follows_a_recorded_temperature_is_no_cycle(tmp_path: Path) -> None:
    temperature = 25 + np.sin(2 * np.pi * CYCLE_TIME / 500 + 0.7)
    (finding,) = cycling(tmp_path, 500.0, temperature).findings
    assert finding.effect == "accelerometer.bias_temperature"


def test_a_smooth_drift_is_no_cycle(tmp_path: Path) -> None:
    accel = CYCLE_NOISE * np.random.default_rng(3).standard_normal((len(CYCLE_TIME), 3)) + [0, 0, 1.0]
    accel[:, 0] += CYCLE * np.tanh((CYCLE_TIME - 1500) / 600)
    found = diagnose([soak(tmp_path, accel)])
    assert not [each for each in found.findings if each.effect == "accelerometer.bias_cycle"]
