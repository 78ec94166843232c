"""What came of measurements, for people and files: solutions, reports, diagnoses, histories, certificates."""
