from dataclasses import replace

from procedures.frames import POSITIONS
from procedures.planning.campaign_design import usual_design
from procedures.planning.told_effects import ToldEffect, effects_told
from tests.procedures.planning.bench_of_moves import HALVES, bench, order, unit


def told(design) -> dict[str, ToldEffect]:
    return {one.name: one for one in effects_told(bench(unit()), design)}


def test_twelve_placings_and_turns_tell_what_is_known_that_they_do() -> None:
    """docs/effects.md: K2 is one with the parallelism of an uncertified cube, K3 with the scale factor."""
    usual = told(usual_design(moves=False))
    assert not usual["accelerometer.quadratic"].is_told
    assert not usual["accelerometer.cubic"].is_told
    assert usual["accelerometer.bias_drift"].is_told
    assert usual["gyroscope.g_sensitivity"] == ToldEffect("gyroscope.g_sensitivity", True)
    assert usual["gyroscope.scale_asymmetry"].is_told
    assert "gyroscope.bias_temperature" not in usual  # nobody plans temperatures


def test_turns_one_way_alone_do_not_tell_an_asymmetry_and_no_turn_tells_nothing_of_scale() -> None:
    usual = usual_design(moves=False)
    one_way = replace(usual, placings=tuple(at for at in usual.placings if at.turn is None or at.turn % 2 == 0))
    assert not told(one_way)["gyroscope.scale_asymmetry"].is_told
    assert not told(replace(order(list(POSITIONS)), moves=False))["gyroscope.scale_asymmetry"].is_told


def test_moves_tell_an_asymmetry_and_the_second_order_that_placings_alone_do_not() -> None:
    halves = told(order(HALVES))
    assert halves["gyroscope.scale_asymmetry"].is_told
    quadratic = halves["accelerometer.quadratic"]
    assert quadratic.is_told
    assert quadratic.not_apart == ("accelerometer.scale_asymmetry",)
