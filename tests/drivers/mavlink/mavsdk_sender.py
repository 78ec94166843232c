"""An autopilot made with MAVSDK's own C++ stack: `python mavsdk_sender.py udpout://HOST:PORT`, until killed."""

import sys
import time

from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.telemetry_server.telemetry_server import FixType, GpsInfo, RawGps, TelemetryServer


def main(url: str) -> None:
    """Send a raw fix ten times a second."""
    stack = Mavsdk(Configuration.create_with_component_type(ComponentType.AUTOPILOT))
    stack.add_any_connection(url)
    server = TelemetryServer(stack.server_component(0))
    satellites = GpsInfo(num_satellites=17, fix_type=FixType.FIX_3D)
    while True:
        fix = RawGps(
            timestamp_us=time.time_ns() // 1000, latitude_deg=47.1234567, longitude_deg=8.7654321,
            absolute_altitude_m=512.5, hdop=0.8, vdop=1.2, velocity_m_s=3.5, cog_deg=123.4,
            altitude_ellipsoid_m=560.0, horizontal_uncertainty_m=0.9, vertical_uncertainty_m=1.5,
        )  # fmt: skip
        server.publish_raw_gps(fix, satellites)
        server.publish_unix_epoch_time(time.time_ns() // 1000)
        time.sleep(0.1)


if __name__ == "__main__":
    main(sys.argv[1])
