"""What many calibrations of a unit, or of all units of a model, say together.

``series`` one parameter over calibrations, ``adjusted`` p-values of many tests at once, ``repeatability`` from one
turn-on to the next, ``process`` how a parameter may move and how well each way fits, ``chart`` the control chart,
``prediction`` the value at a later date, ``fleet`` units that stand out, ``groups`` cubes, slabs, sites or
operators that do. Times are days, values and sigmas in the parameter's own unit.
"""
