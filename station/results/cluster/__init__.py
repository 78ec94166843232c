"""Much work of one kind: on one core, on all of this machine, or on a Dask cluster; restartable.

`engine.open_engine` finds who does the work; `restartable.map_restartable` maps a function over items and keeps
each result as it arrives.
"""
