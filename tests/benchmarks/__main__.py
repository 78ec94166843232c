"""Print every benchmark's table, in the size that fits a coffee break: `make benchmark`.

``docs/measured.md`` holds the long runs' figures and the command of each.
"""

import subprocess
import sys

RUNS = (
    ("times",),
    ("start",),
    ("decode_rate",),
    ("paper", "--seeds", "40"),
    ("count_rate", "--dwells", "48"),
    ("coverage", "--campaigns", "60"),
    ("budget", "--campaigns", "60"),
    ("hostile_frames", "--frames", "100000"),
    ("hostile_mavlink", "--frames", "100000"),
    ("mavlink_rate",),
    ("hostile_slcan", "--lines", "100000"),
    ("hostile_camera", "--parts", "100000"),
    ("camera_cost",),
    ("can_decode",),
    ("can_rate", "--seconds", "30"),
    ("replug", "--times", "20"),
    ("frozen_screen",),
    ("two_writers",),
    ("tolerance",),
    ("exported_c", "--samples", "20000"),
    ("resolve", "--campaigns", "60", "--repeats", "1"),
    ("mutations", "--times", "300"),
    ("screen_cpu",),
    ("kills", "--kills", "12"),
    ("false_accept", "--trials", "140"),
    ("attitude", "--parts", "speed", "bench", "paper", "--seeds", "5"),
    ("monitor", "--seeds", "1"),
    ("stream", "--seconds", "20"),
    ("guiding", "heading", "--trials", "100"),
    ("guiding", "seating", "--trials", "5"),
)

if __name__ == "__main__":
    for name, *options in RUNS:
        print(f"\n== {name} {' '.join(options)}", flush=True)
        subprocess.run([sys.executable, "-m", f"tests.benchmarks.{name}", *options], check=True)
