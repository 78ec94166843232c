from dataclasses import replace

import numpy as np
import pytest

from procedures.fusion.fusion_records import antenna, is_usable, level_fixes, origin_at
from procedures.gnss_records import FixType, GnssFix

HERE = GnssFix("GPS_RAW_INT", 1, 0, FixType.FIX_3D, latitude=0.5, longitude=1.0, height=100.0, altitude=80.0)


def changed(**fields: object) -> GnssFix:
    return replace(HERE, **fields)


def test_a_fix_is_usable_with_a_place_in_three_dimensions_of_its_own() -> None:
    assert is_usable(HERE)
    assert is_usable(changed(height=None))
    assert is_usable(changed(fix=FixType.RTK_FIXED))
    assert not is_usable(changed(fix=FixType.FIX_2D))
    assert not is_usable(changed(is_filtered=True))
    assert not is_usable(changed(height=None, altitude=None))
    assert not is_usable(changed(latitude=None))


def test_of_several_antennas_the_first_is_used() -> None:
    second, given = changed(source="GPS2_RAW"), changed(source="GPS_INPUT")
    assert antenna([second, given, HERE]) == "GPS_RAW_INT"
    assert antenna([second, given]) == "GPS_INPUT"
    assert antenna([second, changed(fix=FixType.NO_FIX)]) == "GPS2_RAW"
    assert antenna([]) == ""


def test_places_are_metres_east_north_up_and_velocities_by_speed_and_course() -> None:
    # 100 m up; 1e-6 rad north by the meridian's radius at 0.5 rad, a (1 - e2) / (1 - e2 sin2 B)^1.5 + 100 m
    radius = 6378137.0 * (1 - 0.00669438) / (1 - 0.00669438 * np.sin(0.5) ** 2) ** 1.5 + 100
    there = changed(latitude=0.500001, height=110.0, speed=5.0, course=np.pi / 6, v_up=-1.0, speed_std=0.3)
    fixes = level_fixes(origin_at(HERE), np.array([0.0, 1.0]), [HERE, there])
    assert fixes.p_n[0] == pytest.approx([0, 0, 0], abs=1e-8)
    assert fixes.p_n[1] == pytest.approx([0, radius * 1e-6, 10.0], abs=1e-4)
    assert fixes.v_n[1] == pytest.approx([2.5, 5 * np.cos(np.pi / 6), -1.0])
    assert np.isnan(fixes.v_n[0]).all()
    assert np.isnan(level_fixes(origin_at(HERE), np.zeros(1), [changed(speed=5.0, course=0.0)]).v_n[0, 2])
    assert fixes.velocity_std == pytest.approx([0.2, 0.3])


def test_a_sigma_is_the_root_mean_square_of_the_axes_where_it_is_stated() -> None:
    cases = [(3.0, 6.0), (3.0, None), (None, 6.0), (None, None)]
    made = [changed(horizontal_std=level, vertical_std=up) for level, up in cases]
    std = level_fixes(origin_at(HERE), np.zeros(4), made).position_std
    # height 1.5 times as uncertain as the place, 5 m where a receiver states none
    whole = [(3.0, 6.0), (3.0, 4.5), (5.0, 6.0), (5.0, 7.5)]
    assert std == pytest.approx([np.sqrt((2 * level**2 + up**2) / 3) for level, up in whole])


def test_without_a_height_above_the_ellipsoid_that_above_the_sea_is_taken() -> None:
    low, high = changed(height=None), changed(height=None, altitude=95.0)
    assert level_fixes(origin_at(low), np.zeros(1), [high]).p_n[0] == pytest.approx([0, 0, 15.0], abs=1e-6)
