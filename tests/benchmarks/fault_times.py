"""How long until a fault of a line is told and until samples come again: `python -m tests.benchmarks.fault_times`.

Each fault of `tests.station.stream.reader.faulty` at the device's own speed, on a pty, TCP, an slcan adapter and
`udp_multicast` at once, by the real reader process. Told: from the last sample before the fault to the words.
Again: from the fault's end, which is as long after that sample as the fault lasts, to the first sample. By the
station's clock where the samples are decoded, in seconds.
"""

import argparse
import math

from tests.station.stream.reader.faulty import (
    BEGIN_S,
    CASES,
    PERIOD,
    SLOT_S,
    TRANSPORTS,
    Case,
    Run,
    begins_s,
    has_said,
    run_all,
)

TOLD_S, AGAIN_S = 2.0, 3.0
LEAD_S = 1.0  # what is on its way when a pty is unplugged is lost with it


def times(run: Run, case: Case) -> tuple[float, float]:
    """Return how long [s] until a case is told, nan where it need not be, and until samples come after its end."""
    begins = round(begins_s(case) / PERIOD)
    over = begins + round(case.lasts_s / PERIOD)
    last = next(at for at, newest in run.came if newest >= begins - 1)
    again = next(at for at, newest in run.came if newest >= over)
    expected = case.said_on(run.transport)
    if not expected:
        return math.nan, again - last - case.lasts_s
    heard = (at for at, text in run.heard if at >= last - LEAD_S and has_said([text], expected))
    told = next(heard, math.inf)
    return max(told - last, 0.0), again - last - case.lasts_s


def main() -> int:
    """Print the table; exit 1 where it is not as asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--speed", type=float, default=1.0, help="device seconds a second")
    runs, is_good = run_all(parser.parse_args().speed), True
    print(f"{'told / samples again [s]':<24}" + "".join(f"{each:>18}" for each in TRANSPORTS))
    for case in CASES:
        if begins_s(case) < BEGIN_S:
            continue
        found = [times(runs[each], case) for each in TRANSPORTS]
        is_good &= not any(told > TOLD_S or again > AGAIN_S for told, again in found)
        cells = [f"{'-' if math.isnan(told) else f'{told:.2f}'} / {max(again, 0.0):.2f}" for told, again in found]
        print(f"{case.name:<24}" + "".join(f"{cell:>18}" for cell in cells))
    print(f"asked: told within {TOLD_S:g} s, samples again within {AGAIN_S:g} s; a slot is {SLOT_S:g} s")
    return 0 if is_good else 1


if __name__ == "__main__":
    raise SystemExit(main())
