"""Whatever a test here reads is read by the witness, too: the two have to agree where both understand all of it."""

from __future__ import annotations

from pathlib import Path

import pytest
from two_readings import differences

from camrob.errors import InputError
from camrob.toolpath.defaults import Defaults
from camrob.toolpath.toolpath import Toolpath
from camrob.witness.cl import read_story

MOST = 60_000  # bytes: longer files have tests of their own (tests/witness/test_witness_cl_corpus.py)
# Tests whose files may be read in two ways, and why
DIFFER = {"test_any_program_is_read_or_refused": "drawn at random: blocks that no control takes"}


def _read_alike(data: bytes, name: str, path: Toolpath, options: dict[str, object], folder: Path) -> None:
    """Fails where the witness, which understands all of the file, reads another path."""
    if len(data) > MOST:
        return
    file = folder / "second_reading" / name
    file.parent.mkdir(exist_ok=True)
    file.write_bytes(data)
    kinematics, given = options.get("kinematics"), options.get("defaults") or Defaults()
    assert isinstance(given, Defaults)
    try:
        story = read_story(
            file,
            dialect=options.get("dialect") or (f"gcode-{kinematics}" if kinematics else None),  # type: ignore[arg-type]
            units=options.get("units"),  # type: ignore[arg-type]
            default_feed=given.feed or options.get("feed"),  # type: ignore[arg-type]
            default_rpm=given.spindle_rpm or options.get("spindle_rpm"),  # type: ignore[arg-type]
            tools=given.diameters or options.get("diameters"),  # type: ignore[arg-type]
            wear=given.wear or bool(options.get("wear")),
            numbers=given.numbers or options.get("numbers"),  # type: ignore[arg-type]
        )
    except InputError:
        return
    if story.complete and (found := differences(path, story)):
        pytest.fail("\n".join([*found, data.decode("latin-1")[:2000]]), pytrace=False)


@pytest.fixture(autouse=True)
def second_reading(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Holds each file that the test reads to the witness's reading of it."""
    if request.node.originalname in DIFFER:
        return

    def wrapped(read):
        def reads(path, *data, **options):
            found = read(path, *data, **options)
            _read_alike(data[0] if data else Path(path).read_bytes(), Path(path).name, found, options, tmp_path)
            return found

        return reads

    for name in ("read_toolpath", "read_gcode", "read_cl"):
        if hasattr(request.module, name):
            monkeypatch.setattr(request.module, name, wrapped(getattr(request.module, name)))
