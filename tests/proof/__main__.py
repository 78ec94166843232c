"""Run proofs and keep what they measured in docs/evidence: `python -m tests.proof NAME ...`, or `--all`."""

import argparse
import sys

from tests.proof import pages
from tests.proof.evidence import Proof, figures, measure, write
from tests.proof.registry import PROOFS


def run(proof: Proof, size: int, seed: int) -> bool:
    """Run a proof, print its numbers and keep them; return whether all are as asked."""
    print(f"== {proof.name}: {proof.shows} ({size:,} {proof.unit})", flush=True)
    try:
        document = measure(proof, size, seed)
    except (ImportError, FileNotFoundError) as error:
        print(f"   not run, something is missing on this machine: {error}", flush=True)
        return True
    write(document, proof.file)
    found = figures(document)
    for name, figure in found.items():
        print(f"   {name}: {figure.value:g} {figure.unit}{'' if figure.is_met else '   NOT AS ASKED'}", flush=True)
    print(f"   {document['seconds']:g} s", flush=True)
    return all(figure.is_met for figure in found.values())


def main(arguments: list[str] | None = None) -> int:
    """Run what is asked for; return 1 where a number is not as asked."""
    parser = argparse.ArgumentParser(prog="python -m tests.proof", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PROOFS))
    parser.add_argument("--all", action="store_true", help="every proof")
    parser.add_argument("--quick", action="store_true", help="in a size that takes minutes")
    parser.add_argument("--size", type=int, help="of one proof")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--pages", action="store_true", help="write docs/evidence/README.md from what is there")
    asked = parser.parse_args(arguments)
    if unknown := set(asked.names) - set(PROOFS):
        parser.error(f"no proof {', '.join(sorted(unknown))}; there are {', '.join(PROOFS)}")
    is_good = True
    for name in PROOFS if asked.all else asked.names:
        proof = PROOFS[name]
        is_good &= run(proof, asked.size or (proof.quick if asked.quick else proof.size), asked.seed)
    if asked.pages or asked.all or asked.names:
        pages.PAGE.write_text(pages.page(), encoding="utf-8")
    else:
        print("\n".join(f"{proof.name:<18} {proof.shows}" for proof in PROOFS.values()))
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
