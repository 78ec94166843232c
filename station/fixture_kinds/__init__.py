"""The kinds of fixtures as they are shown, one file each; a line here puts a kind on the list.

A kind's file has ``lines(session)``, one line for each of that kind by name, and ``description(session, name)``.
"""

KINDS = {
    "cube": "station.fixture_kinds.cube",
    "slab": "station.fixture_kinds.slab",
    "site": "station.fixture_kinds.site",
    "imu": "station.fixture_kinds.imu",
}
