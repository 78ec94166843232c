"""The kinds of fixtures as they are shown, one file each; a line here puts a kind on the list.

A kind's file has ``lines(session)``, one line for each of that kind by name, and ``description(session, name)``.
"""

KINDS = {
    "cube": "station.results.fixture_kinds.cube",
    "slab": "station.results.fixture_kinds.slab",
    "site": "station.results.fixture_kinds.site",
    "imu": "station.results.fixture_kinds.imu",
}
