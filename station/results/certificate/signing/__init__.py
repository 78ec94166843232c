"""Certificates signed and checked: XAdES of XML, PAdES of PDF, time stamps, keys and whom they belong to."""
