"""The site that fixes average to."""

from dataclasses import replace

from procedures.earth.gnss_records import FixType, GnssFix, averaged_site

FIX = GnssFix("GPS_RAW_INT", 1, 0, FixType.FIX_3D, latitude=0.8, longitude=0.2, altitude=500.0)


def test_fixes_alike_to_the_last_digit_are_said_to_be() -> None:
    same, scattered = [FIX] * 20, [replace(FIX, latitude=0.8 + i * 1e-9) for i in range(20)]
    for fixes, is_constant in ((same, True), (scattered, False), (same[:19], False)):
        site = averaged_site(fixes)
        assert site is not None
        assert site.is_constant == is_constant
