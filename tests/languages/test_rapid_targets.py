"""The replay's reader and the witness take Offs and RelTool to the same places."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.languages.rapid.reader.data import Data
from camrob.languages.rapid.reader.expressions import UnknownError
from camrob.languages.rapid.reader.tokens import tokens_of
from camrob.witness.rapid.records import NotSaidError, Records

TARGET = "[[10,20,30],[0.5,0.5,-0.5,0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


@pytest.mark.parametrize("call", ["OFFS(P,1,-2,3)", "RELTOOL(P,1,-2,3)", "RELTOOL(OFFS(P,0,5,0),0,0,-40)"])
def test_both_readers_move_a_target_alike(call: str) -> None:
    records, data = Records(), Data()
    records.declare("ROBTARGET", "P", TARGET)
    data.declare("ROBTARGET", "P", data.value(tokens_of(TARGET)))
    second, first = records.value(call), data.value(tokens_of(call))
    assert isinstance(first, list) and isinstance(second, list)
    np.testing.assert_allclose(np.array(first[0], float), np.array(second[0], float), atol=1e-9)


def test_a_target_with_too_few_numbers_is_moved_nowhere() -> None:
    """A lost comma, [[80,300],...], was a traceback of the reader."""
    records, data, broken = Records(), Data(), TARGET.replace("[10,20,30]", "[1020,30]")
    records.declare("ROBTARGET", "P", broken)
    data.declare("ROBTARGET", "P", data.value(tokens_of(broken)))
    with pytest.raises(UnknownError):
        data.value(tokens_of("OFFS(P,1,2,3)"))
    with pytest.raises(NotSaidError):
        records.value("OFFS(P,1,2,3)")
