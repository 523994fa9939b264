"""G codes that set the stage: planes, units, offsets, feed modes, TCP, tilted planes, machine positions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from camrob.errors import ToolpathError
from camrob.findings import Severity
from camrob.toolpath.cutter_offset import offset_by_control
from camrob.toolpath.gcode.coordinates import ToolFrame
from camrob.toolpath.gcode.cut_path import PathGrower
from camrob.toolpath.gcode.lexer import Block
from camrob.toolpath.gcode.program_frame import euler
from camrob.toolpath.gcode.state import SCALES, Modal
from camrob.toolpath.gcode.transforms import (
    end_rotation,
    end_scaling,
    haas_mirror,
    mirror,
    polar,
    rotate,
    scale,
    unmirror,
)
from camrob.units import deg_to_rad

__all__ = ["aim", "apply_setup", "compensate"]

_DEGREE = deg_to_rad(1.0)
Handler = Callable[[int, Block, Modal, ToolFrame, PathGrower], bool]

# G codes in tenths
_REFUSED = {
    52: ("a NURBS block (G5.2)", "export lines and arcs"),
    62: ("a NURBS curve (G6.2)", "export lines and arcs"),
    70: ("diameter programming (G7)", "export a milling program"),
    120: ("a circular pocket (G12)", "have the CAM system write the moves out"),
    130: ("a circular pocket (G13)", "have the CAM system write the moves out"),
    1500: ("a pocket (G150)", "have the CAM system write the moves out"),
    71: ("a cylinder's surface (G7.1)", "export X, Y, Z"),
    121: ("polar interpolation (G12.1)", "export X, Y, Z"),
    161: ("polar coordinates (G16.1)", "export X, Y, Z"),
    310: ("a probing move (G31)", "post without probing"),
    **dict.fromkeys((382, 383, 384, 385), ("a probing move (G38)", "post without probing")),
    330: ("threading (G33)", "mill the thread, or leave it out"),
    331: ("rigid tapping, which needs a spindle coupled to the feed (G33.1)", "mill the thread, or leave it out"),
    2540: ("a work offset that turns with the table (G254)", "post with TCP on (G234, G43.4) or with G68.2 and G53.1"),
    2680: ("a feature coordinate system (G268)", "post with G68.2 and G53.1, or with TCP on (G234)"),
    650: ("a macro call (G65)", "have the CAM system write plain blocks"),
    660: ("a macro call (G66)", "have the CAM system write plain blocks"),
    683: ("a tilted plane by points or vectors (G68.3)", "use G68.2 with Euler angles"),
    684: ("a tilted plane that adds to another (G68.4)", "use one G68.2"),
    760: ("a G76 cycle", "write the moves out"),
    870: ("back boring (G87)", "write the moves out"),
    880: ("a G88 cycle, which waits for the operator's hand", "write the moves out"),
    842: ("rigid tapping, which needs a spindle coupled to the feed (G84.2)", "use G84, or mill the thread"),
    843: ("rigid tapping, which needs a spindle coupled to the feed (G84.3)", "use G74, or mill the thread"),
    960: ("constant surface speed (G96)", "export a milling program with S in rev/min"),
    411: ("dynamic cutter compensation (G41.1)", "let the CAM system offset the path"),
    421: ("dynamic cutter compensation (G42.1)", "let the CAM system offset the path"),
    1070: ("a cylinder's surface (G107)", "export X, Y, Z"),
    1120: ("polar interpolation (G112)", "export X, Y, Z"),
}
# Codes that pass alone, but whose coordinates are no place to go to.
_NO_COORDINATES = {
    431: "a tool length by its words (G43.1)",
    432: "a further tool length by its words (G43.2)",
    500: "a block of G50 with coordinates",
    620: "G62 with coordinates, by which Okuma's controls mirror,",
    630: "tapping as a move (G63)",
}
# Fanuc's high-speed modes and look-ahead by their own letter: how fast the path is run, not where (B-63944EN, 20).
_LOOK_AHEAD = {50: "P", 51: "Q", 80: "P"}
# Offsets that are only cancelled by P0.
_CANCELLED = {
    542: "a fixture offset that turns (G54.2)",
    544: "a workpiece error compensation (G54.4)",
}
# Path modes, exact stop, tool length, plain defaults: the cell decides, or nothing is to be done.
_SILENT = frozenset(
    (
        80,
        90,
        281,
        301,
        431,
        432,
        500,
        610,
        611,
        630,
        640,
        641,
        670,
        690,
        970,
        131,
        220,
        230,
        250,
        260,
        620,
        1030,
        1870,
        2550,
    )
)
_MOVES = frozenset((0, 10, 20, 30))
# Of each of these one holds: of two in a block, LinuxCNC takes none, and others the last one.
_GROUPS = tuple(
    frozenset(group)
    for group in ((170, 180, 190), (200, 210), (700, 710), (900, 910), (901, 911), (930, 940, 950), (980, 990))
)
_PLANE_ORDERS = frozenset(("121", "131", "212", "232", "313", "323"))


def apply_setup(codes: list[int], block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """Carry the codes (tenths, no motion among them) out, in the order in which controls do.

    True where they used the block's coordinates up. Raises ToolpathError for codes that are refused or unknown.
    """
    consumed = False
    if len(codes) > 1:
        _one_of_each(codes)
    for code in sorted(codes, key=lambda c: _RANK.get(c, 99)):
        handler = _HANDLERS.get(code)
        if handler is not None:
            consumed = handler(code, block, modal, frame, path) or consumed
        elif code in _LOOK_AHEAD and _LOOK_AHEAD[code] in block.words:
            if any(block.words.get(letter) for letter in "XYZABCIJK"):
                raise ToolpathError(f"G{code / 10:g} with coordinates is not read", hint="export lines and arcs")
            consumed = True
        elif code in _CANCELLED:
            if block.words.get("P") != 0.0:
                raise ToolpathError(f"{_CANCELLED[code]} is not read", hint="post in the part's frame")
        elif code in _REFUSED:
            what, hint = _REFUSED[code]
            raise ToolpathError(f"{what} is not read", hint=hint)
        elif code in _NO_COORDINATES and not (code == 630 and _MOVES & set(block.g)):
            if not set("XYZABC").isdisjoint(block.words):
                raise ToolpathError(f"{_NO_COORDINATES[code]} is not read", hint="write plain moves (G0, G1)")
        elif code not in _SILENT:
            raise ToolpathError(
                f"G{code / 10:g} is not known here: it may move the path", hint="post without it, or take it out"
            )
        if code == 690:
            end_rotation(modal, frame)
        elif code == 500:
            end_scaling(modal, frame)
    return consumed


def _one_of_each(codes: list[int]) -> None:
    """Refuse two modes of one group in a block."""
    for group in _GROUPS:
        if len(both := sorted(group & set(codes))) > 1:
            raise ToolpathError(
                f"G{both[0] / 10:g} and G{both[1] / 10:g} in one block", hint="keep the one that is meant"
            )


def _units(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    scale = SCALES["inch" if code == 200 else "mm"]
    modal.stated = True
    if not modal.forced:
        modal.scale = scale
    elif modal.scale != scale:
        path.note("units-overridden", f"G{code // 10} is overruled by the units asked for", block.line)
    return False


def _old_units(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G70 and G71 alone: inches and millimetres (Mach3, Fagor, older controls). With words, they are cycles elsewhere."""
    if not set("FSTDH").issuperset(block.words):
        raise ToolpathError(
            f"G{code // 10} with words of its own (a bolt circle, a turning cycle, Okuma's return level) is not read",
            hint="have the post-processor write the moves out",
        )
    return _units(200 if code == 700 else 210, block, modal, frame, path)


def _modal(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    if code in (170, 180, 190):
        modal.plane = code
    elif code in (900, 910):
        modal.incremental = code == 910
    elif code in (901, 911):
        modal.absolute_center = code == 901
    elif code in (980, 990):
        modal.return_to_r = code == 990
    elif code != modal.feed_mode:
        modal.feed_mode = code
        modal.feed = None
    return False


def _compensation(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G40, G41, G42: the side; what the block's D says of the radius is not read yet (see `compensate`)."""
    modal.side = {410: "G41, RL", 420: "G42, RR"}.get(code, "")
    return False


def compensate(block: Block, modal: Modal, path: PathGrower) -> None:
    """The D word of a block, and whether the path is the tool centre's where a compensation is in force.

    Raises ToolpathError where the control would have to offset the path. A tool change brings the tool's own D along.
    """
    before = modal.edge
    if "T" in block.words or 60 in block.m:
        modal.edge = None
    modal.edge = block.words.get("D", modal.edge)
    if not modal.side or (modal.edge == before and {410, 420}.isdisjoint(block.g)):
        return
    if modal.edge == 0.0 and modal.zero_edge:
        why = "D0 has no radius"
    elif modal.wear:
        why = "the set-up says that it is the tool centre's"
    else:
        raise offset_by_control(modal.side)
    path.note("cutter-compensation", f"cutter radius compensation: the path runs as programmed, {why}", block.line)


def _length(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    modal.measured, modal.unmeasured = True, False
    return False


def _tcp(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    if code != 490 and frame.plane is not None:
        raise ToolpathError(f"TCP (G{code / 10:g}) in a tilted plane (G68.2)", hint="cancel the plane with G69 first")
    modal.vectors = code == 435
    modal.unmeasured = code == 490 and modal.measured
    frame.switch_tcp(code != 490, by_m=False)
    if modal.vectors and any(letter in block.words for letter in "IJK"):
        aim(block, modal, frame)
    return False


def aim(block: Block, modal: Modal, frame: ToolFrame) -> None:
    """The tool's axis by the I, J and K of a block (G43.5). Raises ToolpathError where they make none."""
    if modal.incremental:
        raise ToolpathError("a tool axis by I, J, K in G91", hint="post in absolute coordinates (G90)")
    frame.aim((block.words.get("I", 0.0), block.words.get("J", 0.0), block.words.get("K", 0.0)))


def _offset(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    if modal.take_offset(code, block):
        frame.forget()
        path.lose()
    return False


def _machine(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G28, G30, G53: a place that only the machine knows; the coordinates that the block names are not known behind it.

    G28 and G30 go there by way of the point that the block names.
    """
    named = "".join(letter for letter in "XYZABC" if letter in block.words)
    if code == 530 and not named:
        if block.g == (530,) and not block.words and modal.keeps_motion:
            _offset(code, block, modal, frame, path)
        return False
    if code == 530 and {20, 30} & {modal.motion, *block.g}:
        raise ToolpathError("an arc to a machine position (G53)", hint="use G0 or G1 with G53")
    cuts = 10 in block.g or (modal.motion == 10 and 0 not in block.g)
    if code == 530 and cuts and path.cutting and set("XY") & set(named):
        raise ToolpathError(
            "a cut to a machine position (G53 with G1) straight out of another", hint="lift the tool first, or use G0"
        )
    if modal.polar is not None and set("XY") & set(named) and code != 530:
        raise ToolpathError("G28 by way of a point in polar coordinates (G16)", hint="put G15 before it")
    steps = not modal.incremental or any(block.words[letter] for letter in named)
    if code != 530 and named and steps:  # first to the point that the block names, which is one of the program's
        frame.move({k: v for k, v in block.words.items() if k in named}, modal.scale, _DEGREE, modal.incremental)
        if frame.placeable and frame.known:
            modal.first_move(block.line)
            path.rapid(frame.stance(), block.line)
    path.lose(home=True)
    frame.forget(named or "XYZ")
    away = code == 300 or (code == 530 and any(block.words[letter] for letter in named if letter in "ABC"))
    if away and set("ABC") & set(named):  # another place than the machine's zero, where the rotary axes stand upright
        frame.angles = [
            math.nan if letter in named else angle for letter, angle in zip("ABC", frame.angles, strict=True)
        ]
    if not named:  # whether the rotary axes go along is the machine's affair
        frame.angles = [math.nan if angle else 0.0 for angle in frame.angles]
    path.note(
        "machine-position",
        "moves to machine positions (G28, G30, G53) are left out: the cell's own retract takes their place",
        block.line,
        Severity.INFO,
    )
    return True


def _shift(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    if any(letter in block.words for letter in "ABC"):
        raise ToolpathError("G52 with rotary words is not read", hint="post without it")
    shift = [block.words[a] * modal.scale if a in block.words else v for a, v in zip("XYZ", frame.shift, strict=True)]
    if shift != frame.shift:
        if not frame.placeable and frame.known:
            raise ToolpathError("G52 with turned axes and the tool centre point off", hint="post with TCP on")
        frame.set_shift(shift)
    return True


def _origin(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G10 and G92: offsets of the machine's, harmless before the first move."""
    if code == 100 and block.words.get("L") in (1.0, 10.0, 11.0):  # the tool table
        if modal.moved and modal.length is not None and block.words.get("P") == modal.length:
            raise ToolpathError("G10 changes the length in use, in the middle of the program", hint="put it first")
        return True
    if modal.moved:
        raise ToolpathError(
            f"G{code / 10:g} moves the origin in the middle of the program", hint="post with one work offset"
        )
    path.note(
        "origin-set",
        "the origin that G10 or G92 sets is the machine's: the part is placed by the set-up",
        block.line,
        Severity.INFO,
    )
    if code == 920:
        frame.move({k: v for k, v in block.words.items() if k in "XYZ"}, modal.scale, 0.0, False)
    return True


def _cancel_origin(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    if modal.moved:
        raise ToolpathError(f"G{code / 10:g} in the middle of the program", hint="post with one work offset")
    return False


def _tilt(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G68.2: origin X Y Z and three Euler angles I J K; P0 and a Q that names the order of axes are read, too."""
    words = block.words
    order = f"{words.get('Q', 313.0):g}"
    if words.get("P", 0.0) != 0.0 or order not in _PLANE_ORDERS or not set("ABCR").isdisjoint(words):
        raise ToolpathError("a tilted plane (G68.2) other than by Euler angles", hint="post with G68.2 X Y Z I J K")
    if frame.shift != [0.0, 0.0, 0.0]:
        raise ToolpathError("a tilted plane (G68.2) on top of G52", hint="put the shift into G68.2's origin")
    angles = (words.get("I", 0.0), words.get("J", 0.0), words.get("K", 0.0))
    a, b, c = (deg_to_rad(value) for value in angles)
    origin = np.array([words.get(letter, 0.0) * modal.scale for letter in "XYZ"])
    frame.tilt(euler(order, (a, b, c)), origin)
    return True


def _orient(code: int, block: Block, modal: Modal, frame: ToolFrame, path: PathGrower) -> bool:
    """G53.1, G53.6: tool onto the tilted plane's normal; G53.3 with a move to X Y Z of the plane."""
    if any(letter in block.words for letter in "ABC"):
        raise ToolpathError("G53.1 with rotary words", hint="the control finds the angles itself: leave them out")
    path.lose()
    frame.orient()
    return False


# G codes in tenths
_HANDLERS: dict[int, Handler] = {
    **dict.fromkeys((200, 210), _units),
    **dict.fromkeys((700, 710), _old_units),
    **dict.fromkeys((170, 180, 190, 900, 910, 901, 911, 930, 940, 950, 980, 990), _modal),
    **dict.fromkeys((400, 410, 420), _compensation),
    430: _length,
    **dict.fromkeys((434, 435, 2340, 490), _tcp),
    **dict.fromkeys((540, 541, 1540, 550, 560, 570, 580, 590, 591, 592, 593, 5000, *range(5050, 6000, 10)), _offset),
    **dict.fromkeys((280, 300, 530), _machine),
    520: _shift,
    **dict.fromkeys((100, 920), _origin),
    501: unmirror,
    511: mirror,
    680: rotate,
    510: scale,
    **dict.fromkeys((1000, 1010), haas_mirror),
    **dict.fromkeys((150, 160), polar),
    **dict.fromkeys((921, 922, 923), _cancel_origin),
    682: _tilt,
    **dict.fromkeys((531, 533, 536), _orient),
}
# In which order the codes of one block are carried out.
_RANK = {
    int(code): rank
    for rank, code in enumerate(
        "930 940 950 170 180 190 200 210 700 710 400 410 420 690 490 430 434 435 2340 540 "
        "541 1540 550 560 570 580 590 591 592 593 5000 900 910 901 911 980 990 280 300 100 "
        "520 501 1000 500 511 1010 510 680 150 160 920 921 922 923 682 531 533 536 530".split()
    )
}
