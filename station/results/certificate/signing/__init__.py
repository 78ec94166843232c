"""Certificates signed and verified: XAdES of XML, PAdES of PDF, time stamps, keys and whom they belong to.

`signing_key` or `token_key` signs and `time_stamp` dates what `xml_signature` and `pdf_signature` write.
`verification` reads signatures again, with `key_certificate` for trust and
`xml_schema` for the format.
"""
