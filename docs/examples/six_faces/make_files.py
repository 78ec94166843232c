"""Make the six files of this campaign as a counter with a carried remainder does: `python make_files.py`."""

import math
import random
from pathlib import Path

UP = {1: (1, 0, 0), 3: (-1, 0, 0), 5: (0, 1, 0), 7: (0, -1, 0), 9: (0, 0, 1), 11: (0, 0, -1)}
K, D = (1020.0, 1015.0, 1018.0), (0.001, 0.002, 0.001)  # count/(g s), g
PERIOD, SAMPLES = 0.02, 1000

random.seed(1)
for number, (position, up) in enumerate(UP.items()):
    begin = 60.0 * number  # s of device time: steps may not overlap
    total = [random.random() for _ in range(3)]
    lines = ["t_s,ax,ay,az"]
    for sample in range(1, SAMPLES + 1):
        counts = []
        for axis in range(3):
            before = math.floor(total[axis])
            total[axis] += K[axis] * (up[axis] + D[axis] + random.gauss(0, 1e-5)) * PERIOD
            counts.append(math.floor(total[axis]) - before)
        lines.append(f"{begin + sample * PERIOD:.3f},{counts[0]},{counts[1]},{counts[2]}")
    Path(f"dwell_{position:02d}.csv").write_text("\n".join(lines) + "\n")
