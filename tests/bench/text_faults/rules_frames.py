"""Frames and what else gives the numbers their meaning: `$TOOL`, `$BASE`, mechanisms, orientation."""

from __future__ import annotations

import re

from text_faults.context import Draw, NothingToDrawError
from text_faults.rules import rule
from text_faults.tree import At, Tree


def _aggregate_moved(text: str, name: str, by: float) -> str:
    """A frame with a number added to one component."""
    return re.sub(rf"\b{name} (-?[\d.]+)", lambda f: f"{name} {float(f[1]) + by:.5f}", text, count=1)


def _inside(draw: Draw) -> At:
    """A line of a cut, to put something before."""
    return draw.cut().at


@rule("frames", times=3)
def a_number_of_tool(draw: Draw) -> Tree:
    at = draw.line("set", "$TOOL")
    name, by = draw.rng.choice(
        [("X", 0.06), ("Y", -0.11), ("Z", 0.05), ("Z", -2.0), ("B", 0.03), ("A", 2.0), ("C", 0.5)]
    )
    return draw.tree.put(at, _aggregate_moved(draw.tree.at(at).text, name, by))


@rule("frames")
def a_sign_of_tool(draw: Draw) -> Tree:
    at = draw.line("set", "$TOOL")
    name = draw.rng.choice("YZC")
    return draw.tree.put(
        at, re.sub(rf"\b{name} (-?)", lambda f: f"{name} {'' if f[1] else '-'}", draw.tree.at(at).text, count=1)
    )


@rule("frames", "wrong")
def tool_without_its_angles(draw: Draw) -> Tree:
    """What an aggregate leaves out is not what stood there."""
    at = draw.line("set", "$TOOL")
    return draw.tree.put(at, re.sub(r",A .*?}", "}", draw.tree.at(at).text))


@rule("frames", only=("tools",))
def tool_of_the_other_number(draw: Draw) -> Tree:
    first, second = draw.lines("set", "$TOOL")
    change = draw.rng.choice([(first, second), (second, first)])
    return draw.tree.put(change[0], draw.tree.at(change[1]))


@rule("frames", only=("tools",))
def tool_not_switched(draw: Draw) -> Tree:
    return draw.tree.put(draw.lines("set", "$TOOL")[1])


@rule("frames", only=("tools",))
def tool_switched_late(draw: Draw) -> Tree:
    at = draw.lines("set", "$TOOL")[1]
    m = draw.next_motion(at, draw.rng.choice([1, 2, 4]))
    return draw.tree.edit({at: [], m.at: [m.node, draw.tree.at(at)]})


@rule("frames", only=("tools",))
def tool_switched_early(draw: Draw) -> Tree:
    at = draw.lines("set", "$TOOL")[1]
    m = draw.pick([m for m in draw.motions if m.cut and draw.place(m.at) < draw.place(at)])
    return draw.tree.edit({at: [], m.at: [draw.tree.at(at), m.node]})


@rule("frames", "wrong")
def no_tool(draw: Draw) -> Tree:
    return draw.tree.put(draw.lines("set", "$TOOL")[0])


@rule("frames", "wrong")
def null_frame_for_tool(draw: Draw) -> Tree:
    return draw.tree.put(draw.line("set", "$TOOL"), "$TOOL = $NULLFRAME")


@rule("frames", "wrong", times=2)
def tool_by_another_name(draw: Draw) -> Tree:
    """A number of the controller's own list, whatever stands there."""
    line = draw.rng.choice(
        ["$TOOL = TOOL_DATA[3]", "BAS (#TOOL,2 )", "BAS(#TOOL,7)", "$TOOL = $TOOL : {X 0,Y 0,Z 1.0,A 0,B 0,C 0}"]
    )
    return draw.tree.before(_inside(draw), line)


@rule("frames", "wrong", times=2)
def a_component_of_tool_set(draw: Draw) -> Tree:
    """Behind the header, where one reads for whole frames only."""
    line = draw.rng.choice(
        ["$TOOL.Z = 410.0", "$TOOL.X = 0.5", "$TOOL.Z = $TOOL.Z + 0.2", "$TOOL.A = 15.0", "$TOOL.C=-150"]
    )
    return draw.tree.before(_inside(draw), line)


@rule("frames", times=3)
def a_number_of_base(draw: Draw) -> Tree:
    at = draw.line("set", "$BASE")
    name, by = draw.rng.choice(
        [("X", 0.05), ("Y", -0.1), ("Z", 0.03), ("Z", -20.0), ("A", 0.1), ("B", 0.05), ("C", -0.5)]
    )
    return draw.tree.put(at, _aggregate_moved(draw.tree.at(at).text, name, by))


@rule("frames", "wrong", times=2)
def base_without_ek(draw: Draw) -> Tree:
    """The base that stands still while the table has turned."""
    text = draw.rng.choice(["{X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}", "$NULLFRAME", "BASE_DATA[1]", "$WORLD"])
    return draw.tree.put(draw.line("set", "$BASE"), f"$BASE = {text}")


@rule("frames", "wrong", times=2)
def base_set_again(draw: Draw) -> Tree:
    header = draw.tree.at(draw.line("set", "$BASE")).text
    line = draw.rng.choice(
        [
            "$BASE = {X 0.0,Y 0.0,Z -1.0,A 0.0,B 0.0,C 0.0}",
            "BAS (#BASE,1 )",
            "$BASE = BASE_DATA[2]",
            "$BASE = $NULLFRAME",
            _aggregate_moved(header, "Z", -0.5),
            _aggregate_moved(header, "A", 0.3),
            "$BASE = $BASE : {X 0.0,Y 0.0,Z -1.0,A 0.0,B 0.0,C 0.0}",
            "BAS (#EX_BASE,1 )",
        ]
    )
    return draw.tree.before(_inside(draw), line)


@rule("frames", "wrong", times=2)
def a_component_of_base_set(draw: Draw) -> Tree:
    line = draw.rng.choice(["$BASE.Z = -0.3", "$BASE.X = 5.0", "$BASE.A = 1.0", "$BASE.Z = $BASE.Z - 2.0", "$base.z=1"])
    return draw.tree.before(_inside(draw), line)


@rule("frames", "wrong")
def no_base(draw: Draw) -> Tree:
    return draw.tree.put(draw.line("set", "$BASE"))


@rule("frames", "wrong")
def base_behind_the_first_motions(draw: Draw) -> Tree:
    """Set only once the tool is in the cut."""
    at = draw.line("set", "$BASE")
    m = draw.pick([m for m in draw.motions if m.cut][:1])
    return draw.tree.edit({at: [], m.at: [draw.tree.at(at), m.node]})


@rule("frames", "wrong")
def base_of_another_mechanism(draw: Draw) -> Tree:
    at = draw.line("set", "$BASE")
    text = draw.tree.at(at).text
    change = draw.rng.choice(
        [("MACHINE_DEF[2].ROOT", "MACHINE_DEF[1].ROOT"), ("[2]", "[3]"), ("[2].MECH_TYPE", "[1].MECH_TYPE")]
    )
    return draw.tree.put(at, text.replace(*change))


@rule("frames", "wrong")
def another_external_mechanism(draw: Draw) -> Tree:
    at = draw.line("set", "$ACT_EX_AX")
    return draw.rng.choice(
        [
            draw.tree.put(at, f"$ACT_EX_AX = {draw.rng.choice([0, 1, 3])}"),
            draw.tree.before(_inside(draw), f"$ACT_EX_AX = {draw.rng.choice([0, 1])}"),
        ]
    )


@rule("frames", "wrong", times=2)
def what_the_numbers_mean(draw: Draw) -> Tree:
    """Interpolation mode, foot, world, asynchronous axes."""
    line = draw.rng.choice(
        [
            "$IPO_MODE = #TCP",
            "$ROBROOT = {X 1000.0,Y 0.0,Z 500.0,A 0.0,B 0.0,C 0.0}",
            "$ROBROOT.Z = 1.0",
            "$ASYNC_AXIS = 'B0011'",
            "$ASYNC_AXIS = 2",
            "$WORLD = {X 0.0,Y 0.0,Z 5.0,A 0.0,B 0.0,C 0.0}",
            "$ERSYSROOT = {X 1.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}",
            "$EX_AX_ASYNC = 2",
            "ASYPTP {E2 90.0}",
            "$ASYNC_EX_AX_DECOUPLE = 'B0010'",
        ]
    )
    return draw.tree.before(draw.rng.choice([_inside(draw), draw.line("set", "$TOOL")]), line)


@rule("frames", "wrong", only=("tilted", "turning"))
def orientation_kept(draw: Draw) -> Tree:
    """The tool does not turn although the points say so."""
    if draw.rng.random() < 0.5:
        return draw.tree.put(draw.line("set", "$ORI_TYPE"), "$ORI_TYPE = #CONSTANT")
    return draw.tree.before(_inside(draw), "$ORI_TYPE = #CONSTANT")


@rule("frames", "wrong", only=("tilted", "turning"))
def orientation_by_the_wrist_axes(draw: Draw) -> Tree:
    """#JOINT: the tool's axis goes another way between the points."""
    return draw.tree.put(draw.line("set", "$ORI_TYPE"), "$ORI_TYPE = #JOINT")


@rule("frames", "wrong", only=("tilted",))
def orientation_about_the_path(draw: Draw) -> Tree:
    """#PATH on an arc cut with a leaning tool: the lean turns with the arc."""
    at = draw.line("set", "$CIRC_TYPE")
    m = draw.motion(lambda m: m.node.kind == "circ")
    return draw.rng.choice([draw.tree.put(at, "$CIRC_TYPE = #PATH"), draw.tree.before(m.at, "$CIRC_TYPE = #PATH")])


@rule("frames", "open", only=("arcs", "tools"))
def orientation_about_the_path_upright(draw: Draw) -> Tree:
    """#PATH with an upright tool: only the roll differs."""
    return draw.tree.put(draw.line("set", "$CIRC_TYPE"), "$CIRC_TYPE = #PATH")


@rule("frames", "open", only=("arcs", "holes"))
def orientation_kept_upright(draw: Draw) -> Tree:
    """#CONSTANT with an upright tool: the roll stays, and so other postures than those written."""
    return draw.tree.put(draw.line("set", "$ORI_TYPE"), "$ORI_TYPE = #CONSTANT")


@rule("frames", "wrong", only=("split",))
def a_frame_set_in_a_part(draw: Draw) -> Tree:
    """In the second file, where nobody looks for one."""
    file = draw.pick([f for f in draw.tree.files if f.endswith("_002.src")])
    at = next(a for a in draw.order if a.file == file and draw.tree.at(a).moves)
    line = draw.rng.choice(
        ["$BASE = {X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}", "$TOOL = {X 0.0,Y 0.0,Z 300.0,A 0.0,B 0.0,C 0.0}"]
    )
    return draw.tree.before(at, line)


@rule("frames", "wrong")
def nothing_set(draw: Draw) -> Tree:
    """The whole INI block lost: no tool, no base, no speeds."""
    lines = [a for a in draw.order if draw.tree.at(a).kind in ("bas", "set")]
    first = draw.place(draw.motions[0].at)
    kept = {a: [] for a in lines if draw.place(a) < first}
    if not kept:
        raise NothingToDrawError
    return draw.tree.edit(kept)  # type: ignore[arg-type]
