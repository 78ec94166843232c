"""What was measured about cubes, slabs and sites, and every calibration ever accepted.

`database` opens it (`schema`, `migrations`) and each write is kept in the `journal`; `fixtures`,
`fixture_measurements`, `imu_models`, `campaigns`, `stored_calibrations` and `issued_certificates` add rows,
chained where they are append-only (`hash_chain`, `append_only_rows`); `verification` reports what was altered,
also since an anchor that was kept elsewhere.
"""
