"""The Earth: `geodesy` (gravity, rate, coordinates), `gyrocompass` (heading), `gnss_records` (fixes)."""
