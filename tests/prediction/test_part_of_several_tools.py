"""Programs that change their tool: the part that they cut, each groove by its own cutter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from calibration_sample import calibration
from process_story import GCODE, KR15, TOOL_FRAMES, TWO_TOOLS, posted

from camrob.errors import CamrobError, InputError, ProgramError, SetupError
from camrob.jobs.post import PostResult
from camrob.jobs.predict import predict

CUT = TWO_TOOLS.replace("diameter_mm", "corner_radius_mm = 0\ndiameter_mm", 1).replace(
    "diameter_mm = 6", "corner_radius_mm = 3\ndiameter_mm = 6"
)
PUSHED = """[[tool]]
number = {}
along_um_n = {}
[tool.mean]
along_n = 0
across_n = 0
axial_n = {}
"""
STOCK = "[stock]\nbox_mm = [-60, -30, -5, 60, 40, 6]\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> PostResult:
    return posted(tmp_path_factory.mktemp("several"), "part.nc", GCODE, setup=TWO_TOOLS)


def test_the_part_of_several_tools_is_cut_by_each_of_them(made: PostResult, tmp_path: Path) -> None:
    """Grooves as wide as each tool, at each one's depth; and all 0.2 mm too high on a machine whose base is, by formula."""
    (tmp_path / "setup.toml").write_text(CUT + STOCK)
    known = {"setup": tmp_path / "setup.toml", "calibration": calibration(tmp_path / "fitted.toml", {"base.z": 2e-4})}
    part = predict(made.out / "part.src", cell=KR15, out=tmp_path / "out", pitch_mm=0.5, **known)
    point, off = part.surface.point * 1e3, part.surface.deviation * 1e3
    floor = part.surface.normal[:, 2] > 0.99
    np.testing.assert_allclose(off[floor], 0.2 * part.surface.normal[floor, 2], atol=1e-2)
    for x, depth, half in ((10.0, 2.0, 5.0), (35.0, 2.0, 3.0)):
        here = (np.abs(point[:, 0] - x) < 2.0) & (np.abs(point[:, 1]) < 6.0)
        # a ray half a pitch beside the ball's lowest line meets it 0.0104 mm higher
        np.testing.assert_allclose(point[here & floor, 2].min(), depth, atol=1.1e-2)
        walls = here & (point[:, 2] > 5.0)
        np.testing.assert_allclose(np.abs(point[walls, 1]).max(), half, atol=2e-3)
    assert "run-out of the tool" in part.summary.not_judged and part.summary.holder is None
    # pushed up and down by forces at which joints hardly give
    known["force"] = tmp_path / "FORCE.toml"
    known["force"].write_text(PUSHED.format(1, 100.0, 1) + PUSHED.format(2, 50.0, -2))
    pushed = predict(made.out / "part.src", cell=KR15, out=tmp_path / "pushed", pitch_mm=0.5, **known)
    point, off, up = pushed.surface.point * 1e3, pushed.surface.deviation * 1e3, pushed.surface.normal[:, 2] > 0.99
    for x, expected in ((10.0, 0.3), (35.0, 0.1)):
        here = up & (np.abs(point[:, 0] - x) < 2.0) & (np.abs(point[:, 1]) < 1.0) & (point[:, 2] < 3.0)
        np.testing.assert_allclose(off[here], expected, atol=1.5e-2)
    assert (
        pushed.summary.force.words.startswith("on mill 10 0 N along")
        and "; on ball 6 0 N" in pushed.summary.force.words
    )


def test_tools_that_nothing_tells_apart_are_not_predicted(made: PostResult, tmp_path: Path) -> None:
    """A set-up with one tool, one whose tools have other frames, one whose tools share one; and a force, which is of one tool."""
    setup = tmp_path / "setup.toml"
    known = {"cell": KR15, "out": tmp_path / "out", "setup": setup}
    known["calibration"] = calibration(tmp_path / "fitted.toml", {"base.z": 2e-4})

    def refused(text: str, error: type[CamrobError], match: str, **more: Path) -> None:
        setup.write_text(text)
        with pytest.raises(error, match=match):
            predict(made.out / "part.src", **known, **more)

    refused(CUT.partition("[[tool]]\nnumber = 2")[0] + STOCK, ProgramError, "more than one tool frame.*one tool")
    refused(
        CUT.replace("355.0", "356.0") + STOCK, SetupError, "none of its tools has the program's frame with X 12.000"
    )
    first, second = (str(list(frame)) for frame in TOOL_FRAMES)
    refused(CUT.replace(second, first) + STOCK, SetupError, "mill 10, ball 6 have one frame, and nothing else")
    (tmp_path / "FORCE.toml").write_text("[mean]\nalong_n = 50\nacross_n = 0\naxial_n = 0\n")
    refused(CUT + STOCK, InputError, "pushes on one tool, and part.src sets 2", force=tmp_path / "FORCE.toml")
