"""The calibration certificate: a stored calibration as ISO/IEC 17025:2017 wants it handed out.

`content` collects what is reported, from the chained record and `laboratory`, with `printed_results`, `conformity`
and `model_statement`; `sentences` has what page and XML both say; `missing_statements` refuses what is incomplete;
`rendering` (HTML, PDF) and `dcc` (XML) write it; `issuing` numbers and records it; `signing` signs and verifies
its files.
"""
