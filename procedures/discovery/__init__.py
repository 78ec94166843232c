"""Terms that no catalogue holds, found: a library made by machine, its scores, and which of them stand.

`factors` are combined to the terms of the `library`; `discover` scores them against what a diagnosis leaves and
returns those that are likelier than all else; `next_plan` is the measurement that separates their readings.
"""
