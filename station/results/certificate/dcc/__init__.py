"""The certificate as XML: a digital calibration certificate of PTB's schema 3.1.2, quantities in D-SI 2.1.

It is made from the same statements as the HTML (`station.results.certificate.content`), so that the two cannot
disagree; ``schema`` holds the schemas unmodified, with their licence.
docs/how-to/certificate.md maps what stands where.
"""
