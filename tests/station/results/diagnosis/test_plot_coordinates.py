"""What a finding's residual is drawn against: by hand, at three rows seen at four nodes."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from procedures.diagnosis.result import Finding
from station.results.diagnosis.plot_coordinates import coordinate_of, means_at_rows

NAN = float("nan")
WEIGHTS = [
    SimpleNamespace(rows=slice(0, 2), nodes=np.array([[0, 1], [2, 3]]).T),
    SimpleNamespace(rows=slice(2, 3), nodes=np.array([[3]]).T),
]
STEPS = tuple(
    SimpleNamespace(kind=kind, position=position, name=name)
    for kind, position, name in (("dwell", 7, "dwell_07.csv"), ("turn", 1, "turn_z.csv"), ("dwell", 9, "dwell_09"))
)


def seen(**fields: Any) -> Any:
    excitation = SimpleNamespace(
        t=np.array([3600.0, 7200.0, 10800.0, 18000.0]), temperature=np.array([20.0, 22.0, NAN, 30.0]),
        temperature_rate=np.zeros(4), steps=STEPS, auxiliary={"lamp": np.array([1.0, 3.0, 5.0, 7.0])},
        f=np.arange(12.0).reshape(4, 3), omega=-np.arange(12.0).reshape(4, 3), magnetic=np.zeros((4, 3)),
        change=np.zeros((4, 3)),
    )  # fmt: skip
    for name, value in fields.items():
        setattr(excitation, name, value)
    return SimpleNamespace(
        excitation=excitation,
        weights=WEIGHTS,
        residual=np.zeros(3),
        step=np.array([2, 0, 1]),
        axis=np.array([0, 2, 1]),
    )


def finding(
    effect: str, coefficients: tuple[str, ...] = (), value: tuple[float, ...] = (), **where: object
) -> Finding:
    values = np.array(value or [1.0] * len(coefficients))
    std = np.where(np.isnan(values), 0.0, 0.1)
    return Finding(
        effect, "instrument", coefficients, np.nan_to_num(values), std, "g", where, "likely", (), "", -9.0, 1.0
    )


ALL, ADDED = np.ones(3, dtype=bool), np.array([0.5, 0.6, 0.7])


def drawn(found: Finding, evidence: Any = None, rows: Any = ALL) -> Any:
    return coordinate_of(evidence or seen(), found, rows, ADDED, "ug")


def test_a_row_has_the_mean_of_what_is_known_at_its_nodes() -> None:
    assert means_at_rows(seen(), np.array([20.0, 22.0, NAN, 30.0])).tolist() == [21.0, 30.0, 30.0]
    lost = means_at_rows(seen(), np.array([20.0, 22.0, NAN, NAN]))
    assert lost[0] == 21.0
    assert np.isnan(lost[1:]).all()
    wide = means_at_rows(seen(), np.arange(8.0).reshape(4, 2))
    assert wide.tolist() == [[1.0, 2.0], [5.0, 6.0], [6.0, 7.0]]


def test_time_is_in_hours_from_the_first_node_known() -> None:
    found = drawn(finding("accelerometer.bias_drift"), seen(t=np.array([NAN, 7200.0, 10800.0, 18000.0])))
    assert found.label == "time [h]"
    assert found.values.tolist() == [0.0, 2.0, 3.0]


def test_each_row_has_what_its_own_sensor_sees() -> None:
    found = drawn(finding("accelerometer.quadratic"))
    assert found.label == "specific force along the sensor [g]"
    assert found.values.tolist() == [1.5, 9.5, 10.0]  # of sensors x, z, y
    assert drawn(finding("gyroscope.sagnac_sine"), rows=np.array([False, True, True])).values.tolist() == [
        -9.5,
        -10.0,
    ]


def test_the_input_is_that_of_each_sensors_surest_coefficient() -> None:
    """Of x the first, 3 of its sigma before 2 of the other; of y the one that is not known exactly; of z none."""
    of = finding("gyroscope.g_sensitivity", ("xz", "xy", "yx", "yz"), (-0.3, 0.2, 0.1, NAN))
    assert drawn(of).values.tolist() == [1.5 + 2, 7.5, 9.0]
    assert drawn(of).label == "specific force, along the input that matters most [g]"


def test_a_sensor_that_lags_is_drawn_against_the_temperature_it_has_come_to() -> None:
    evidence = seen(sensor_temperature={90.0: np.array([20.0, 21.0, 24.0, 28.0]), 0.0: np.full(4, NAN)})
    found = drawn(finding("accelerometer.temperature_lag", ("x", "tau_s"), (1.0, 90.0)), evidence)
    assert found.label == "temperature that the sensor has come to [degC]"
    assert found.values.tolist() == [20.5, 26.0, 28.0]
    assert drawn(finding("accelerometer.temperature_lag", ("x",)), evidence).names == ("7", "turn_z", "9")


def test_an_auxiliary_channel_is_drawn_by_its_name_and_one_that_is_not_there_by_steps() -> None:
    found = drawn(finding("auxiliary.channel", channel="lamp"))
    assert found.label == "lamp"
    assert found.values.tolist() == [2.0, 6.0, 7.0]
    assert drawn(finding("auxiliary.channel", channel="heater")).names == ("7", "turn_z", "9")


def test_what_has_no_coordinate_is_drawn_by_steps_in_their_order() -> None:
    found = drawn(finding("placement.dwell"))
    assert found.label == "position, turn or rest"
    assert found.values.tolist() == [2.0, 0.0, 1.0]
    assert found.names == ("7", "turn_z", "9")
    some = drawn(finding("placement.dwell"), rows=np.array([True, False, True]))
    assert some.values.tolist() == [1.0, 0.0]
    assert some.names == ("turn_z", "9")


def test_a_norm_of_all_three_sensors_is_drawn_against_what_the_effect_adds() -> None:
    evidence = seen()
    evidence.axis = np.array([0, -1, 1])
    found = drawn(finding("accelerometer.quadratic"), evidence)
    assert found.label == "what accelerometer.quadratic adds [ug]"
    assert found.values.tolist() == ADDED.tolist()
    evidence.axis = np.array([0, 0, 1])
    assert drawn(finding("accelerometer.quadratic"), evidence).values.tolist() == [1.5, 7.5, 10.0]
