import pytest

from fixtures_db.database import Database
from fixtures_db.imu_models import Limit, covered, limited_models, limits_of, set_limits


def test_a_name_without_an_axis_means_every_axis(db: Database) -> None:
    with db.write() as session:
        set_limits(
            session,
            "FOG-3",
            [Limit("accelerometer.bias", -2e-3, 2e-3, "g", 2.0), Limit("residual.p_value", 0.01, None, "1")],
        )
    with db.read() as session:
        found = limits_of(session, "FOG-3")
        assert limits_of(session, "FOG-9") == ()
        assert limited_models(session) == ["FOG-3"]
    assert found == (
        *(Limit(f"accelerometer.bias.{axis}", -2e-3, 2e-3, "g", 2.0) for axis in "xyz"),
        Limit("residual.p_value", 0.01, None, "1"),
    )
    assert len(covered("gyroscope.misalignment")) == len(covered("fixture.parallelism")) == 6
    assert covered("gyroscope.bias.x") == ("gyroscope.bias.x",)


def test_new_limits_take_the_place_of_all_of_that_model_and_of_no_other(db: Database) -> None:
    for model, parameter in (("A", "slab.tilt"), ("B", "slab.tilt"), ("A", "slab.tilt.east")):
        with db.write() as session:
            set_limits(session, model, [Limit(parameter, None, 1e-4, "rad")])
    with db.read() as session:
        assert [len(limits_of(session, model)) for model in "AB"] == [1, 2]


@pytest.mark.parametrize(
    ("limit", "reported"),
    [
        (("accelerometer.bais", 0.0, 1.0, "g"), r"accelerometer\.scale_factor"),
        (("accelerometer", 0.0, 1.0, "g"), "gyroscope"),
        (("residual", 0.0, 1.0, "g"), "gyroscope"),
        (("accelerometer.bias", 0.0, 1.0, "ug"), "the unit"),
        (("accelerometer.bias", None, None, "g"), "low"),
        (("accelerometer.bias", 1.0, 0.0, "g"), "low"),
        (("accelerometer.bias", 0.0, float("nan"), "g"), "low"),
        (("accelerometer.bias", 0.0, 1.0, "g", -1.0), "guard_band"),
        (("residual.p_value", 0.01, None, "1", 1.0), "p_value"),
    ],
)
def test_what_is_no_limit_is_refused(limit: tuple[object, ...], reported: str) -> None:
    with pytest.raises(ValueError, match=reported):
        Limit(*limit)  # type: ignore[arg-type]


def test_a_parameter_is_limited_once(db: Database) -> None:
    twice = [Limit("gyroscope.bias", -1.0, 1.0, "deg/h"), Limit("gyroscope.bias.y", -1.0, 1.0, "deg/h")]
    with pytest.raises(ValueError, match=r"gyroscope\.bias\.y once"), db.write() as session:
        set_limits(session, "FOG-3", twice)


def test_the_guard_band_narrows_both_sides_by_the_values_own_sigma() -> None:
    assert Limit("slab.tilt.east", -1.0, 2.0, "rad", 1.5).accepted(0.1) == (-0.85, 1.85)
    assert Limit("slab.tilt.east", None, 2.0, "rad", 1.5).accepted(0.1) == (-float("inf"), 1.85)
    assert Limit("slab.tilt.east", -1.0, 2.0, "rad").accepted(None) == (-1.0, 2.0)
