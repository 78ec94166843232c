"""The pytest plugin, used as the page on testing says."""

import re
import subprocess
import sys
import tomllib

import pytest

from drivers.simulated import pytest_plugin
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.server import SimulatedDevice
from tests.paths import ROOT

pytest_plugins = ["pytester"]
THREE_LINES, FROM_FILE = re.findall(
    r"```python\n(.*?)```", (ROOT / "docs/how-to/testing.md").read_text(encoding="utf-8"), re.DOTALL
)
WHOLE_FILE = (ROOT / "docs/examples/test_devices.py").read_text(encoding="utf-8")
PLUGIN = ("-p", pytest_plugin.__name__, "-p", "no:cacheprovider")


@pytest.fixture(autouse=True)
def _this_plugin_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")


def test_the_examples_of_the_page_run(pytester: pytest.Pytester) -> None:
    assert FROM_FILE in WHOLE_FILE
    pytester.makepyfile(f"{WHOLE_FILE}\n\n{THREE_LINES}")
    result = pytester.runpytest_inprocess(*PLUGIN, "--strict-markers", "-W", "error")
    result.assert_outcomes(passed=WHOLE_FILE.count("def test_") + 2)


def test_an_unserved_setting_is_an_error_of_the_test_that_says_what_is_accepted(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import pytest

        @pytest.mark.simulated_imu(truth={"colour": 1})
        def test_key(simulated_imu): ...

        @pytest.mark.simulated_imu(faults=[{"kind": "babble", "at_s": 1}])
        def test_fault(simulated_imu): ...

        @pytest.mark.simulated_gnss({"system": 5})
        def test_positional(simulated_gnss): ...
        """
    )
    result = pytester.runpytest_inprocess(*PLUGIN)
    result.assert_outcomes(errors=3)
    result.stdout.fnmatch_lines(["*found key 'colour'*latitude_deg*", "*'babble' of a device that is not on CAN*"])
    result.stdout.fnmatch_lines(["*marker simulated_gnss: found {'system': 5}; expected keywords*"])


def test_what_stops_a_device_fails_the_test(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        from drivers.ports import open_port

        def test_one(simulated_imu):
            simulated_imu.device.chunk = None
            port = open_port(simulated_imu.url)
            while simulated_imu.failure is None:
                port.read(1000)
            port.close()
        """
    )
    result = pytester.runpytest_inprocess(*PLUGIN)
    result.assert_outcomes(passed=1, errors=1)
    result.stdout.fnmatch_lines(["*'NoneType' object is not callable*"])


def test_the_projects_own_tests_have_it_too(simulated_imu: SimulatedDevice, simulated_gnss: SimulatedGnss) -> None:
    assert simulated_imu.url.startswith("serial:///dev/")
    assert simulated_gnss.url.startswith("mavlink:udpout:127.0.0.1:")


def test_the_package_names_it_to_pytest_under_its_modules_name() -> None:
    """As `-p` would: named otherwise, pytest would refuse the one that comes second."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        points = tomllib.load(file)["project"]["entry-points"]["pytest11"]
    assert points == {pytest_plugin.__name__: pytest_plugin.__name__}


def test_loading_it_loads_nothing_else() -> None:
    code = (
        "import sys, pytest; before = set(sys.modules); import drivers.simulated.pytest_plugin; "
        "print(*sorted(set(sys.modules) - before))"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert ran.stdout.split() == ["drivers", "drivers.simulated", "drivers.simulated.pytest_plugin"]
