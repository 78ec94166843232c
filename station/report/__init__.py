"""The calibration report: one HTML file that needs nothing else, on screen or on A4 paper.

`station.report.writing.write_report` writes it from a `station.report.context.ReportContext`.
"""
