"""Little looking for garbage must not change what those see who look for themselves."""

import gc


class Held:
    pass


def test_who_looks_for_garbage_is_told_who_holds_an_object() -> None:
    """Hypothesis asks so in a process's first test where CI is set, and warns where nobody is named."""
    held = [Held()]
    gc.collect()
    assert any(each is held for each in gc.get_referrers(held[0]))
