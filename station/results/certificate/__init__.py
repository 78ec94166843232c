"""The calibration certificate: a stored calibration as ISO/IEC 17025:2017 wants it handed out.

It is made from the chained record and what the laboratory says of itself (``laboratory.toml``), refused while
anything is missing, and recorded as it was issued.
"""
