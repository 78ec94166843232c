"""The calibrations of a unit over time (`history/1`), and of the units of a model (`population/1`).

`unit_history` and `population` compute (limits: `procedures.statistics.calibration_drift`); `unit_history_text`
and `population` print; `history_page` draws both.
"""
