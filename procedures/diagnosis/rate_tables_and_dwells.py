"""A campaign's rate tables beside its dwells and turns: diagnosed apart, told together.

The gyroscopes have a scale factor and bias of their own on the table: another site, mounting, temperature and day.
An effect found in both is told as the bench found it, unless only the table is sure of it.
"""

from collections.abc import Sequence
from dataclasses import replace

from procedures.diagnosis.result import Diagnosis, Finding, Verdict

WEAKEST_LAST: tuple[Verdict, ...] = ("consistent", "established", "likely", "ambiguous", "unexplained")


def combined(bench: Diagnosis, tables: Diagnosis) -> Diagnosis:
    """Return the bench's diagnosis with what the tables found; fits and evidence are the bench's."""
    findings = _told_once(bench.findings, tables.findings)
    verdict = max((bench.verdict, tables.verdict), key=WEAKEST_LAST.index)
    next_measurement = "; ".join(filter(None, (bench.next_measurement, tables.next_measurement)))
    return replace(
        bench, verdict=verdict, findings=findings, tried=(*bench.tried, *tables.tried),
        errors=(*bench.errors, *tables.errors), log_p=min(bench.log_p, tables.log_p),
        next_measurement=next_measurement, on_table=tables.on_table,
    )  # fmt: skip


def with_files(tables: Diagnosis) -> Diagnosis:
    """Return a diagnosis of rate tables whose findings say which files they are of."""
    names = [table.name for each in tables.before.campaigns for table in each.rate_tables]
    where = {"file": names[0] if len(names) == 1 else names}
    return replace(
        tables, findings=tuple(replace(each, where={**each.where, **where}) for each in tables.findings)
    )


def _told_once(bench: Sequence[Finding], tables: Sequence[Finding]) -> tuple[Finding, ...]:
    sure = {each.effect for each in bench if each.confidence != "ambiguous"}
    added = [each for each in tables if each.effect not in sure]
    better = {each.effect for each in added if each.confidence != "ambiguous"}
    return (*(each for each in bench if each.effect not in better), *added)
