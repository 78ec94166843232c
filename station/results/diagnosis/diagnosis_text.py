"""A diagnosis as text to read in 80 columns: the first screen, then the details."""

from collections.abc import Iterator, Mapping, Sequence
from textwrap import wrap
from typing import Any

from station.results.diagnosis.diagnosis_document import (
    CAUSE_COLUMNS,
    STILL_IN,
    Cause,
    DiagnosisDocument,
    Lines,
    Table,
    document_of,
)
from station.results.report.noise_document import noise_summary
from station.text import WIDTH, table_lines

INDENT = "   "


def diagnosis_text(found: Mapping[str, Any]) -> str:
    """Return the text that `station diagnose` prints of a `diagnosis/2`; +- is the standard uncertainty u."""
    return text_of(document_of(found))


def text_of(document: DiagnosisDocument) -> str:
    """Return a diagnosis as text, as it is laid out everywhere."""
    return "\n\n".join("\n".join(part) for part in _parts(document) if part)


def _parts(document: DiagnosisDocument) -> Iterator[list[str]]:
    """Yield what stands apart by an empty line."""
    yield _folded(f"{document.title.upper()}. {document.headline}")
    if document.causes:
        yield [*_cause_lines(document.causes), *_folded(document.cause_note, INDENT)]
    yield _titled("not separable here, and what would separate them", document.not_separable)
    if document.measure_next:
        hint = [f"({document.plan_hint})"] if document.plan_hint else []
        yield [*_folded(f"measure next: {document.measure_next}"), *hint]
    yield _folded(document.searched)
    for number, cause in enumerate(document.causes, 1):
        if cause.is_detailed:
            yield _cause(number, cause)
    for section in document.sections:
        yield section_lines(section)
    still_in = STILL_IN if document.causes else ""
    noise = f"noise at rest, as recorded{still_in}, 95 % (all five terms, spectrum and lines: `station noise`)"
    yield _titled(noise, [*noise_summary(document.noise)])
    yield _folded(f"not observable: {document.not_observable}" if document.not_observable else "")
    yield [line for text in document.warnings for line in _folded(f"warning: {text}")]


def _cause_lines(causes: Sequence[Cause]) -> list[str]:
    """Return the table of causes; sizes stand below names, as four columns are too many for 80 characters."""
    first, _, *more = CAUSE_COLUMNS
    rows = list[tuple[str, ...]]()
    for number, cause in enumerate(causes, 1):
        for name, size, *cells in cause.rows(number):
            rows += [(name, *cells), *([(f"   {size}", *("" for _ in cells))] if size else [])]
    return table_lines(rows, "<<<", (first, *more))


def _cause(number: int, cause: Cause) -> list[str]:
    lines = _folded(f"{number}. {cause.title}{f' ({cause.about})' if cause.about else ''}")
    for text in (*cause.sentences, f"equation: {cause.equation}" if cause.equation else ""):
        lines += _folded(text, INDENT)
    for table in cause.tables:
        lines += section_lines(table)
    return lines + [f"{INDENT}{INDENT}{line}" for line in cause.readings]


def section_lines(section: Table | Lines) -> list[str]:
    """Return a section as lines of text."""
    if isinstance(section, Lines):
        return _titled(section.title, section.lines)
    rows = table_lines(section.rows, section.align, section.header)
    return [*_folded(section.title), *rows, *_folded(section.note, INDENT)]


def _titled(title: str, lines: Sequence[str]) -> list[str]:
    """Return lines below a title, a long one continued in the next; nothing where there are none."""
    return [*_folded(title), *(part for line in lines for part in _folded(line, INDENT))] if lines else []


def _folded(text: str, indent: str = "") -> list[str]:
    """Return text in lines of 80 columns; what fits in one stays as it is."""
    if len(line := f"{indent}{text}") <= WIDTH:
        return [line] if text else []
    return wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent, break_long_words=False)
