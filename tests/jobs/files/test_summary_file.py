"""A summary's file: written as JSON has it, read with a reason, or as nothing where it is none of ours."""

import json
from dataclasses import dataclass
from pathlib import Path

import pytest

from camrob.errors import InputError
from camrob.jobs.files.summary_file import read_summary, said_in, write_summary
from camrob.jobs.release.beside import said_to_be_compensated
from camrob.summaries.base import Summary


@dataclass(frozen=True, slots=True, kw_only=True)
class Said(Summary):
    """Two things."""

    what: str
    size: float


def test_what_is_written_is_read(tmp_path: Path) -> None:
    write_summary(tmp_path / "a.json", Said(what="Flügel", size=0.5))
    assert read_summary(tmp_path / "a.json", hint="") == {"what": "Flügel", "size": 0.5} == said_in(tmp_path / "a.json")
    assert (tmp_path / "a.json").read_text(encoding="utf-8").endswith("}\n")


def test_a_number_that_json_lacks_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_summary(tmp_path / "a.json", Said(what="", size=float("nan")))
    assert not (tmp_path / "a.json").exists()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('{"files": [', "is damaged: it is no whole JSON file"),
        ("[" * 100_000, "is damaged: it is no whole JSON file"),
        ("\udcff", "is damaged: it is no whole JSON file"),
        ("[1, 2]", "is not a summary"),
    ],
)
def test_what_is_no_summary_is_named_or_says_nothing(tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "a.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(InputError, match=f"a.json: {why}; give another"):
        read_summary(tmp_path / "a.json", hint="give another")
    assert said_in(tmp_path / "a.json") == {} == said_in(tmp_path / "none.json")


@pytest.mark.parametrize("program", ["part.src", "part.roughing.src", "part.path.npz"])
def test_a_compensated_program_is_known_by_the_file_of_its_own_name(tmp_path: Path, program: str) -> None:
    stem = program.removesuffix(".src").removesuffix(".path.npz")
    said = {"error_before": 1, "error_after": 0, "calibration": None, "files": [program]}
    assert said_to_be_compensated(tmp_path / program) == ""
    (tmp_path / f"{stem}.json").write_text(json.dumps(said))
    assert said_to_be_compensated(tmp_path / program) == f"{stem}.json"
