"""Locked arrays: private, read-only, and copied no oftener than that needs."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.frozen import digest, locked, sealed


def test_what_somebody_else_can_write_to_is_copied() -> None:
    mine = np.arange(6.0).reshape(2, 3)
    held = locked(mine)
    mine[0, 0] = 7.0
    assert held[0, 0] == 0.0
    shut = np.arange(3.0)
    window = shut[:]  # can be written to, whatever becomes of its base's flag
    shut.setflags(write=False)
    held = locked(shut.view())
    window[0] = 7.0
    assert held[0] == 0.0


def test_what_is_locked_is_not_copied_again_and_stays_so() -> None:
    held = locked(np.arange(6.0).reshape(2, 3))
    again = locked(held, shape=(2, 3))
    assert np.shares_memory(held, again)
    for one in (held, again, sealed(np.zeros(3))):
        with pytest.raises(ValueError, match="read-only"):
            one[...] = 1.0
        with pytest.raises(ValueError, match="WRITEABLE"):
            one.setflags(write=True)
    with pytest.raises(ValueError, match="shape"):
        locked(held, shape=(3, 2))


def test_a_part_or_another_form_is_an_array_of_its_own() -> None:
    """A small piece doesn't keep a large array; what is turned, or of another type, is laid out anew."""
    held = locked(np.arange(6.0).reshape(2, 3))
    for other in (locked(held[:1]), locked(held.T), locked(held, dtype=np.int64), locked(held.reshape(3, 2))):
        assert not np.shares_memory(held, other) and other.flags.c_contiguous
    assert locked(held.T).tolist() == held.T.tolist()


def test_digests_are_those_of_the_bytes() -> None:
    """Whatever lies in memory, also nothing; type and shape count."""
    table = np.arange(6.0).reshape(2, 3)
    assert digest(table.T) == digest(np.array(table.T, order="C")) != digest(table)
    assert len({digest(np.zeros((0, 3))), digest(np.zeros(0)), digest(np.zeros(0, np.int8)), digest(np.zeros(()))}) == 4
