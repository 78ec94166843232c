"""The certificate as XML: a digital calibration certificate (DCC): PTB's schema 3.1.2, D-SI 2.1.

`elements` and `names` make XML elements and bilingual texts; `administrative`, `results` and
`measurement` turn `CertificateContent`, the HTML's source too, into the parts of the file; `digital_certificate`
puts them together and validates them by ``schema`` (unmodified, with its licence) and by the rules of `dcclib`.
"""
