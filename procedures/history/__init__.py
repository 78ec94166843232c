"""What many calibrations of a unit, or of all units of a model, say together.

`repeatability` (one parameter's series, its turn-on scatter, control chart), `drift` (how it changes, its value
at a later date), `population` (units, cubes, plates, sites or operators that differ). Times are days, values and
standard uncertainties in the parameter's own unit.
"""
