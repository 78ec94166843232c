"""Bytes of a text file that does not say its encoding."""


def decoded_text(content: bytes) -> str:
    """Return text in UTF-8, with or without a byte order mark, else in ISO-8859-1.

    The latter is what many editors and measuring programs write; a degree sign would come out as U+FFFD otherwise.
    """
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("iso-8859-1")
