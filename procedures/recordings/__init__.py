"""What the columns of a recording show before anything is estimated.

`time_unit` and `time_decision` (the unit of time), `rest_physics` (whether values at rest are possible).
"""
