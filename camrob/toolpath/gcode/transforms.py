"""Turned, mirrored and scaled frames of Fanuc's and alike: G68, G51.1, G51 (B-63944EN, 6.7 to 6.9 and 15.2), one at a time.

The first block behind one, and behind its end, names X and Y together (B-63944EN, 15.2, asks for it): an axis alone would leave
the other one's place to the control.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.coordinates import ToolFrame
from camrob.toolpath.gcode.cut_path import PathGrower
from camrob.toolpath.gcode.lexer import Block
from camrob.toolpath.gcode.program_frame import PLAIN, about, mirrored, turned
from camrob.toolpath.gcode.state import Modal
from camrob.units import deg_to_rad

__all__ = ["cartesian", "end_rotation", "end_scaling", "haas_mirror", "mirror", "polar", "rotate", "scale", "unmirror"]

_ALIKE = "XY"


def _alone(name: str, block: Block, modal: Modal, frame: ToolFrame, *, again: bool = False) -> None:
    """Raises ToolpathError where another frame is in force, in G91, or in another plane than G17."""
    if not frame.program.plain and not (again and modal.framed == name):
        raise ToolpathError(
            f"{name} on top of {modal.framed or 'another frame'}", hint="let the CAM system turn the path"
        )
    if modal.incremental:
        raise ToolpathError(f"{name} in incremental dimensions (G91)", hint="set the frame in G90")
    if modal.plane != 170 or not set("ABCUVW").isdisjoint(block.words):
        raise ToolpathError(f"{name} in another plane than G17, or with rotary words", hint="let the CAM system do it")


def _center(block: Block, modal: Modal, frame: ToolFrame, letters: str) -> NDArray[np.float64]:
    """The point that stays, m: as the block names it, or where the tool stands."""
    xyz = [block.words[k] * modal.scale if k in block.words else at for k, at in zip("XYZ", frame.xyz, strict=True)]
    if any(math.isnan(xyz["XYZ".index(k)]) for k in letters):
        raise ToolpathError("a frame about a place that is not known", hint="name its centre X and Y")
    return np.asarray(np.nan_to_num(np.array(xyz)))


def rotate(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G68 X Y R: turned about a point, or about where the tool stands."""
    _alone("G68", block, modal, frame)
    if not {"I", "J", "K"}.isdisjoint(block.words) or "R" not in block.words:
        raise ToolpathError("G68 without its angle R, or in space (I, J, K)", hint="use G68 X Y R, or G68.2")
    center = _center(block, modal, frame, _ALIKE) * np.array([1.0, 1.0, 0.0])
    frame.set_program(about(center, turned(deg_to_rad(block.words["R"]))), together=_ALIKE)
    modal.framed = "G68"
    return True


def end_rotation(modal: Modal, frame: ToolFrame) -> None:
    """G69, of G68 and of G68.2."""
    if modal.framed == "G68":
        frame.set_program(PLAIN, together=_ALIKE)
        modal.framed = ""
    frame.untilt()


def mirror(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G51.1 X Y: mirrored at X = .. or Y = .., beside what is mirrored already."""
    _alone("G51.1", block, modal, frame, again=True)
    modal.mirror = modal.mirror | {k: block.words[k] * modal.scale for k in "XYZ" if k in block.words}
    _reflect(modal, frame)
    return True


def unmirror(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G50.1 X Y: those axes are mirrored no longer."""
    named = [k for k in "XYZ" if k in block.words]
    if modal.mirror and not named:
        raise ToolpathError("G50.1 without the axes that it means", hint="name them, G50.1 X0 Y0")
    modal.mirror = {k: v for k, v in modal.mirror.items() if k not in named}
    if modal.framed == "G51.1":
        _reflect(modal, frame)
    return True


def _reflect(modal: Modal, frame: ToolFrame) -> None:
    if not modal.mirror:
        frame.set_program(PLAIN, together=_ALIKE)
        modal.framed = ""
        return
    center = np.array([modal.mirror.get(k, 0.0) for k in "XYZ"])
    frame.set_program(about(center, mirrored("".join(modal.mirror))), together=_ALIKE)
    modal.framed = "G51.1"


def scale(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G51 X Y Z P: all axes scaled about a point, by a factor that is written with its decimal point."""
    _alone("G51", block, modal, frame)
    factor = block.words.get("P", 0.0)
    if not {"I", "J", "K"}.isdisjoint(block.words) or not factor > 0.0 or block.whole_p:
        raise ToolpathError(
            "scaling (G51) by I, J, K, by a factor without decimal point, or by none: its unit is the machine's",
            hint="let the CAM system scale, or write P1.5",
        )
    frame.set_program(about(_center(block, modal, frame, "XYZ"), factor * np.eye(3)), together="XYZ")
    modal.framed = "G51"
    return True


def end_scaling(modal: Modal, frame: ToolFrame) -> None:
    """G50."""
    if modal.framed == "G51":
        frame.set_program(PLAIN, together="XYZ")
        modal.framed = ""


def haas_mirror(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """Haas's G101 X0 Y0, mirrored at the work zero, and G100 X0 Y0, no longer (Mill Operator's Manual, G100/G101)."""
    named = [k for k in block.words if k in "XYZ"]
    if code == 1000 and "T" in block.words:
        raise ToolpathError(
            "a tool change that moves to its place (Brother's G100)",
            hint="post the change as M6, and its moves behind it",
        )
    if not named or set(named) != set(block.words) or any(block.words.values()):
        raise ToolpathError(
            f"G{code // 10} of other words than X0 and Y0 is not read", hint="let the CAM system mirror"
        )
    return (mirror if code == 1010 else unmirror)(code, block, modal, frame, path)


def polar(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G16, polar coordinates: X is the radius about the program's zero, Y the angle (B-63944EN, 8.3); G15 ends them."""
    if code == 150:
        modal.polar = None
        return False
    if "H" in block.words:
        raise ToolpathError(
            "G16 with H (Okuma's machine coordinates) is not read", hint="leave it out: the cell retracts by itself"
        )
    if modal.plane != 170 or frame.plane is not None or not frame.program.plain:
        raise ToolpathError(
            "polar coordinates (G16) in another plane than G17, or in a frame of the program's", hint="export X, Y, Z"
        )
    modal.polar = (math.nan, math.nan)
    return False


def cartesian(block: Block, modal: Modal, frame: ToolFrame) -> Block:
    """A block under G16 with X and Y in place of radius and angle. In G91 the angle adds up; where the tool stands would be the
    pole of a radius.

    Raises ToolpathError for such a radius, for an angle or radius that no block has named, and for arcs about I and J.
    """
    if modal.polar is None or {"X", "Y"}.isdisjoint(block.words):
        return block
    if not {"I", "J", "K", "L"}.isdisjoint(block.words) or modal.plane != 170 or not frame.program.plain:
        raise ToolpathError("polar coordinates (G16) with I, J, K or L, or in another plane", hint="export X, Y, Z")
    radius, angle = modal.polar
    if modal.incremental and "X" in block.words:
        raise ToolpathError("a radius in G91 under G16, whose pole is where the tool stands", hint="name it in G90")
    radius = block.words.get("X", radius)
    angle = block.words.get("Y", angle) + (angle if modal.incremental else 0.0)
    modal.polar = (radius, angle)
    if math.isnan(radius + angle):
        raise ToolpathError("polar coordinates (G16) without both radius and angle", hint="name X and Y behind G16")
    turn = deg_to_rad(angle)
    at = (radius * math.cos(turn), radius * math.sin(turn))
    if modal.incremental:
        stands = frame.xyz[0] / modal.scale, frame.xyz[1] / modal.scale
        at = at[0] - stands[0], at[1] - stands[1]
        if math.isnan(at[0] + at[1]):
            raise ToolpathError("an angle in G91 from a place that is not known", hint="name X and Y in G90")
    return block._replace(words={**block.words, "X": at[0], "Y": at[1]})
