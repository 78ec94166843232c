"""Much work of one kind: on one core, on all of this machine, or on a Dask cluster; restartable."""
