"""Many campaigns solved and diagnosed again, in parallel, and compared with what was known of them: `resolve/1`.

`fleet` sends each campaign as a `work_item` through `parallel_map` (on a cluster: `dask_engine`); `comparison`
compares the result with the previous one.
"""
