"""Files damaged at random: content or a reason, never anything else, and a count that was hit loses nothing."""

import pytest
from damaged_files import AS_BEFORE, NOTED, OTHER, REFUSED, held, kinds, taken, tried

from hognose.errors import InputError

KINDS = kinds()
QUICK = [name for name, kind in KINDS.items() if not kind.slow]


@pytest.mark.parametrize("name", QUICK)
def test_damaged_files_give_content_or_a_reason(name):
    became = tried(KINDS[name], 200, name)
    assert set(became) <= {AS_BEFORE, NOTED, OTHER, REFUSED}
    assert 0 < became[REFUSED] < 200


@pytest.mark.parametrize("name", [name for name, kind in KINDS.items() if kind.slow])
def test_damaged_files_that_other_processes_read_give_content_or_a_reason(name, capfd):
    assert set(tried(KINDS[name], 2, name)) <= {AS_BEFORE, NOTED, OTHER, REFUSED}
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", QUICK)
def test_a_number_that_was_hit_loses_nothing(name):
    """Every digit of the first 300 bytes changed to every other one: as much is read, it is said, or it is refused."""
    kind = KINDS[name]
    data = kind.whole
    whole = held(kind, taken(kind, data))
    for at in range(min(len(data), 300)):
        if not data[at : at + 1].isdigit():
            continue
        for digit in b"0123456789":
            try:
                found = taken(kind, data[:at] + bytes([digit]) + data[at + 1 :])
            except InputError:
                continue
            assert not kind.tells or found.notes or held(kind, found) == whole, (at, digit)
