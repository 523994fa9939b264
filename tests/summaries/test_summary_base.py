"""Summaries are JSON objects: keys in the order of the fields, what is left out, what stands among others, and back again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import FrozenInstanceError, dataclass
from pathlib import Path

import pytest

from camrob.errors import InputError
from camrob.jobs.regressing.compare_summary import comparable
from camrob.summaries.base import Summary, further, keyed, left_out, spread
from camrob.summaries.post_summary import PostSummary

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True, slots=True, kw_only=True)
class Size(Summary):
    x_mm: float
    y_mm: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample(Summary):
    name: str
    size: Size | None = spread()
    source: str = keyed("from")
    by_axis: Mapping[str, Size | None]
    rows: tuple[tuple[int, Size], ...]
    note: str = left_out("")
    parts: tuple[Size, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Open(Summary):
    x: int
    further: Mapping[str, object] = further()


SIZE = Size(x_mm=1.0, y_mm=None)
WHOLE = Sample(
    name="n", size=SIZE, source="s", by_axis={"A1": SIZE, "A2": None}, rows=((3, SIZE),), note="!", parts=(SIZE,)
)
BARE = Sample(name="n", source="s", by_axis={}, rows=())


def test_keys_stand_in_the_order_of_the_fields() -> None:
    x = '{"x_mm": 1.0, "y_mm": null}'
    assert json.dumps(WHOLE.to_json()) == (
        f'{{"name": "n", "x_mm": 1.0, "y_mm": null, "from": "s", "by_axis": {{"A1": {x}, "A2": null}}, '
        f'"rows": [[3, {x}]], "note": "!", "parts": [{x}]}}'
    )
    assert json.dumps(BARE.to_json()) == '{"name": "n", "from": "s", "by_axis": {}, "rows": [], "parts": []}'


@pytest.mark.parametrize("summary", [WHOLE, BARE])
def test_what_was_written_is_read_as_it_was(summary: Sample) -> None:
    assert Sample.from_json(json.loads(json.dumps(summary.to_json()))) == summary


def test_a_summary_cannot_be_changed() -> None:
    by_axis = {"A1": SIZE}
    summary = Sample(name="n", source="s", by_axis=by_axis, rows=[(3, SIZE)])  # type: ignore[arg-type]
    by_axis["A1"] = None  # type: ignore[assignment]
    assert summary.by_axis == {"A1": SIZE} and summary.rows == ((3, SIZE),)
    with pytest.raises(TypeError):
        summary.by_axis["A1"] = SIZE  # type: ignore[index]
    with pytest.raises(FrozenInstanceError):
        summary.name = "m"  # type: ignore[misc]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"nmae": 1}, "Sample has no key 'nmae'"),
        ({"by_axis": {"A1": {"x_mm": 1.0}}}, "Size lacks the key 'y_mm'"),
        ({"by_axis": {"A1": 7}}, "7 is not a Size"),
        ({"from": None, "parts": [{"x_mm": 1.0, "y_mm": None, "z_mm": 0.0}]}, "Size has no key 'z_mm'"),
    ],
)
def test_what_is_no_such_object_is_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Sample.from_json(WHOLE.to_json() | change)


def test_keys_that_no_field_is_there_for_are_kept_where_that_is_said() -> None:
    summary = Open.from_json({"new": [1, {"a": 2}], "x": 3})
    assert summary.x == 3 and summary.further == {"new": (1, {"a": 2})}
    assert json.dumps(summary.to_json()) == '{"x": 3, "new": [1, {"a": 2}]}'


@pytest.mark.parametrize("part", ["engraving", "carving", "relief", "globe"])
def test_a_golden_summary_comes_out_byte_for_byte(part: str) -> None:
    """The golden files were written from plain dictionaries; what they leave out stands at the end, and is left out again."""
    text = (ROOT / "toolpaths" / part / "golden" / f"{part}.json").read_text(encoding="utf-8")
    summary = json.loads(text)
    summary["collisions"]["sampled"] = summary["verified"]["by"] = "as it was"
    summary["manifest"] = {"camrob": "0", "cl_file": {}, "setup": {}, "cell": {}, "program": {}}
    assert json.dumps(comparable(PostSummary.from_json(summary).to_json()), indent=1) + "\n" == text
