"""The demo: `run` (campaign on a simulated `device`), `example_bench` (cube and plate), `comparison`."""
