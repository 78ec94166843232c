"""Every kind of undeclared effect."""

from tests.benchmarks.undeclared_kinds.by_input import BY_INPUT
from tests.benchmarks.undeclared_kinds.by_time import BY_TIME
from tests.benchmarks.undeclared_kinds.kind import Kind
from tests.benchmarks.undeclared_kinds.thermal import THERMAL

EVERY = {kind.name: kind for kind in (*THERMAL, *BY_INPUT, *BY_TIME)}
KINDS: dict[str, Kind] = {k.name: k for k in sorted(EVERY.values(), key=lambda k: not k.right)}
