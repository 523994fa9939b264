"""Legal rewrites of a program's build: what is said twice, by a name, elsewhere or in pieces. All have to pass."""

from __future__ import annotations

import numpy as np

from text_faults.context import Draw, Motion, NothingToDrawError
from text_faults.rules import rule
from text_faults.tree import At, Node, Point, Tree, parse


def _interpolated(m: Motion, share: float) -> Point:
    """A point on the way of a motion whose tool axis stays; A on its shorter way."""
    fields = []
    for name in m.end:
        step = m.end[name] - m.last[name]
        if name in "ABC":
            step = (step + 180.0) % 360.0 - 180.0
        fields.append((name, f"{m.last[name] + share * step:.5f}"))
    return Point("E6POS", tuple(fields))


def _steady(m: Motion) -> bool:
    """Whether the tool's axis is the same at both ends, upright."""
    return bool(m.last) and not m.node.axes and all(abs(p[k]) < 1e-9 for p in (m.last, m.end) for k in "BC")


@rule("build", "legal")
def a_line_in_two(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "lin" and _steady(m) and m.length > 2.0)
    middle = m.node.with_points(_interpolated(m, draw.rng.uniform(0.2, 0.8)), tail=" C_DIS")
    return draw.tree.before(m.at, middle)


@rule("build", "legal")
def a_line_in_five(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "lin" and _steady(m) and m.length > 5.0)
    pieces = [m.node.with_points(_interpolated(m, k / 5), tail=" C_DIS") for k in range(1, 5)]
    return draw.tree.before(m.at, *pieces)


@rule("build", "legal")
def the_same_point_again(draw: Draw) -> Tree:
    """A LIN to where the tool is already."""
    m = draw.lin()
    exact = m.node.with_points(*m.node.points, tail="")
    return draw.tree.put(m.at, exact, exact)


def _on_arc(m: Motion, share: float) -> Point:
    """A point of a CIRC's arc, the rest in proportion."""
    a, b, c = (np.array([p[k] for k in "XYZ"]) for p in (m.last, m.node.points[0].values, m.end))
    u, v = b - a, c - a
    n = np.cross(u, v)
    centre = a + ((u @ u) * np.cross(v, n) + (v @ v) * np.cross(n, u)) / (2 * (n @ n))
    x = a - centre
    y = np.cross(n / np.linalg.norm(n), x)
    angle = share * (np.arctan2((c - centre) @ y, (c - centre) @ x) % (2 * np.pi))
    point = _interpolated(m, share)
    for name, value in zip("XYZ", centre + x * np.cos(angle) + y * np.sin(angle), strict=True):
        point = point.put(name, f"{value:.5f}")
    return point


@rule("build", "legal")
def another_via_on_the_arc(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ" and _steady(m))
    return draw.tree.put(m.at, m.node.with_points(_on_arc(m, draw.rng.uniform(0.3, 0.7)), m.node.points[1]))


@rule("build", "legal")
def an_arc_in_two(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ" and _steady(m))
    first = m.node.with_points(_on_arc(m, 0.25), _on_arc(m, 0.5), tail=" C_DIS")
    return draw.tree.put(m.at, first, m.node.with_points(_on_arc(m, 0.75), m.node.points[1]))


@rule("build", "legal")
def a_speed_again(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.speed > 0.0 and m.node.kind != "ptp")
    return draw.tree.before(m.at, f"$VEL.CP = {m.speed:.6f}")


@rule("build", "legal")
def frames_again(draw: Draw) -> Tree:
    """`$ACT_EX_AX`, `$BASE` and `$TOOL` as they are, in the air."""
    m = draw.motion(lambda m: m.own and m.node.kind == "lin")
    lines = [
        [a for a in draw.lines("set", name) if draw.place(a) < draw.place(m.at)][-1]
        for name in ("$ACT_EX_AX", "$BASE", "$TOOL")
    ]
    return draw.tree.before(m.at, *(draw.tree.at(a) for a in lines))


@rule("build", "legal")
def settings_again(draw: Draw) -> Tree:
    names = ("$APO.CDIS", "$ORI_TYPE", "$CIRC_TYPE", "$ACC.CP", "$ADVANCE")
    m = draw.motion(lambda m: m.index > 0)
    return draw.tree.before(m.at, *(draw.tree.at(draw.line("set", name)) for name in names))


@rule("build", "legal")
def a_smaller_rounding(draw: Draw) -> Tree:
    return draw.tree.put(draw.line("set", "$APO.CDIS"), "$APO.CDIS = 0.2")


@rule("build", "legal")
def another_advance(draw: Draw) -> Tree:
    return draw.tree.put(draw.line("set", "$ADVANCE"), f"$ADVANCE = {draw.rng.choice([1, 3])}")


@rule("build", "legal")
def settings_in_another_order(draw: Draw) -> Tree:
    """The INI block's assignments turned round; `$ACT_EX_AX` stays before `$BASE`."""
    names = ("$ORI_TYPE", "$CIRC_TYPE", "$APO.CDIS", "$VEL.ORI1", "$ACC.CP", "$ADVANCE")
    places = [draw.lines("set", name)[0] for name in names]
    nodes = [draw.tree.at(a) for a in places]
    return draw.tree.edit({a: [n] for a, n in zip(places, nodes[1:] + nodes[:1], strict=True)})


@rule("build", "legal")
def the_template_of_the_panel(draw: Draw) -> Tree:
    """The INI fold that every program made on a panel has."""
    at = draw.lines("bas")[0]
    lines = [
        ";FOLD BASISTECH INI",
        "GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )",
        "INTERRUPT ON 3",
        draw.tree.at(at),
        ";ENDFOLD (BASISTECH INI)",
        ";FOLD USER INI",
        ";Make your modifications here",
        ";ENDFOLD (USER INI)",
    ]
    return draw.tree.put(at, *lines)


@rule("build", "legal")
def home_once_more(draw: Draw) -> Tree:
    """PTP to HOME where the robot stands there already."""
    m = draw.pick([m for m in draw.motions if m.node.axes])
    return draw.tree.put(m.at, m.node, m.node)


@rule("build", "legal")
def home_before_the_end(draw: Draw) -> Tree:
    home = draw.motions[-1]
    return draw.tree.before(draw.tree.lines_of_end(draw.tree.main), home.node)


@rule("build", "legal")
def a_null_motion_first(draw: Draw) -> Tree:
    """The block coincidence that posts begin with."""
    return draw.tree.before(draw.motions[0].at, f"PTP {draw.rng.choice(['$AXIS_ACT', '$POS_ACT', '$AXIS_ACT_MEAS'])}")


def _list_form(point: Point) -> str:
    return str(point).replace(f"{point.kind}: ", "")


@rule("build", "legal")
def home_from_the_list(draw: Draw) -> Tree:
    homes = [m for m in draw.motions if m.node.axes and m.at.file == draw.tree.main]
    made = draw.tree.edit({m.at: ["PTP XHOME"] for m in homes})
    return made.in_list(f"DECL E6AXIS XHOME={_list_form(homes[0].node.points[0])}")


@rule("build", "legal")
def home_from_the_list_with_its_type(draw: Draw) -> Tree:
    homes = [m for m in draw.motions if m.node.axes and m.at.file == draw.tree.main]
    made = draw.tree.edit({m.at: ["PTP XREST"] for m in homes})
    return made.in_list(f"E6AXIS XREST={homes[0].node.points[0]}")


@rule("build", "legal")
def home_from_a_variable(draw: Draw) -> Tree:
    homes = [m for m in draw.motions if m.node.axes and m.at.file == draw.tree.main]
    head = next(a for a in draw.order if draw.tree.at(a).kind == "def")
    first = draw.lines("bas")[0]
    made = {m.at: ["PTP REST"] for m in homes}
    made[head] = [draw.tree.at(head), "DECL E6AXIS REST"]
    made[first] = [f"REST = {homes[0].node.points[0]}", draw.tree.at(first)]
    return draw.tree.edit(made)


@rule("build", "legal")
def points_from_the_list(draw: Draw) -> Tree:
    """Five LINs of the main program by name."""
    lins = [m for m in draw.motions if m.node.kind == "lin" and m.at.file == draw.tree.main]
    some = draw.rng.sample(lins, min(5, len(lins)))
    if not some:
        raise NothingToDrawError
    made = draw.tree.edit({m.at: [f"LIN XP{m.index}{m.node.tail}"] for m in some})
    return made.in_list(*(f"DECL E6POS XP{m.index}={_list_form(m.node.points[0])}" for m in some))


@rule("build", "legal")
def a_speed_from_a_constant(draw: Draw) -> Tree:
    at = draw.pick(
        [a for a in draw.lines("set", "$VEL.CP") if a.file == draw.tree.main] or draw.lines("set", "$VEL.CP")
    )
    if at.file != draw.tree.main:
        raise NothingToDrawError
    return draw.tree.put(at, "$VEL.CP = CUTTING").in_list(f"DECL REAL CUTTING={draw.tree.at(at).value}")


@rule("build", "legal")
def a_speed_from_a_variable(draw: Draw) -> Tree:
    at = draw.line("set", "$VEL.CP")
    head = next(a for a in draw.order if draw.tree.at(a).kind == "def" and a.file == at.file)
    value = draw.tree.at(at).value
    return draw.tree.edit({head: [draw.tree.at(head), "DECL REAL FEED"], at: [f"FEED = {value}", "$VEL.CP = FEED"]})


@rule("build", "legal")
def variables_that_nobody_uses(draw: Draw) -> Tree:
    head = next(a for a in draw.order if draw.tree.at(a).kind == "def")
    made = draw.tree.after(head, "DECL INT I,K", "REAL HEIGHT", "DECL E6POS XSPARE")
    return made.in_list("DECL E6POS XP1={X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0,S 2,T 10,E1 0.0,E2 0.0}", "INT COUNT=3")


@rule("build", "legal")
def a_routine_that_nobody_calls(draw: Draw) -> Tree:
    end = draw.tree.lines_of_end(draw.tree.main)
    return draw.tree.after(end, "", "DEF PARK ( )", "LIN_REL {Z 100.0}", "$OUT[1] = FALSE", "END")


@rule("build", "legal")
def a_file_that_nobody_calls(draw: Draw) -> Tree:
    return draw.tree.with_file("spare.src", "DEF spare ( )\nPTP {A1 10.0}\n$OUT[1] = TRUE\nEND\n")


def _block(draw: Draw) -> tuple[At, At, list[Node]]:
    """Some lines of one file with motions in them."""
    m = draw.motion(lambda m: m.cut)
    last = m.at.index
    nodes = draw.tree.files[m.at.file]
    while (
        last + 1 < len(nodes) and last - m.at.index < 4 and (nodes[last + 1].moves or nodes[last + 1].name == "$VEL.CP")
    ):
        last += 1
    return m.at, At(m.at.file, last), list(nodes[m.at.index : last + 1])


def _taken(draw: Draw, first: At, last: At, *instead: str) -> Tree:
    changes: dict[At, list[str]] = {At(first.file, k): [] for k in range(first.index, last.index + 1)}
    changes[first] = list(instead)
    return draw.tree.edit(changes)


@rule("build", "legal")
def a_part_as_a_local_routine(draw: Draw) -> Tree:
    first, last, nodes = _block(draw)
    made = _taken(draw, first, last, "PIECE ( )")
    return made.after(made.lines_of_end(first.file), "DEF PIECE ( )", *nodes, "END")


@rule("build", "legal")
def a_part_as_a_file(draw: Draw) -> Tree:
    first, last, nodes = _block(draw)
    head = next(a for a in draw.order if draw.tree.at(a).kind == "def" and a.file == first.file)
    made = _taken(draw, first, last, "PIECE7 ( )").after(head, "EXT PIECE7 ( )")
    return made.with_file("PIECE7.src", "\n".join(["DEF PIECE7 ( )", *(n.text for n in nodes), "END"]) + "\n")


@rule("build", "legal", only=("split",))
def a_part_brought_in(draw: Draw) -> Tree:
    """A subprogram's lines in the place of its call."""
    at = draw.line("call")
    name = draw.tree.at(at).name
    inner = [n for n in draw.tree.files[f"{name}.src"] if n.kind not in ("header", "def", "end")]
    extern = next(a for a in draw.lines("ext") if draw.tree.at(a).name == name)
    return draw.tree.edit({at: inner, extern: []}).with_file(f"{name}.src", None)


@rule("build", "legal", only=("split",))
def parts_in_one_file(draw: Draw) -> Tree:
    """All subprograms as local routines of the main file."""
    tree = draw.tree.edit({a: [] for a in draw.lines("ext")})
    for a in draw.lines("call"):
        name = draw.tree.at(a).name
        body = [n for n in draw.tree.files[f"{name}.src"] if n.kind != "header"]
        tree = tree.after(tree.lines_of_end(tree.main), *body).with_file(f"{name}.src", None)
    return tree


@rule("build", "legal", only=("split",))
def declarations_of_parts_in_another_order(draw: Draw) -> Tree:
    places = draw.lines("ext")
    return draw.tree.edit({a: [draw.tree.at(b)] for a, b in zip(places, places[::-1], strict=True)})


@rule("build", "legal")
def a_condition_that_holds(draw: Draw) -> Tree:
    m = draw.cut()
    return draw.tree.put(m.at, "IF TRUE THEN", m.node, "ENDIF")


@rule("build", "open")
def a_jump_to_the_next_line(draw: Draw) -> Tree:
    return draw.tree.before(draw.cut().at, "GOTO ON", "ON:")


@rule("build", "legal")
def outputs_off_first(draw: Draw) -> Tree:
    """Everything off before the first motion, as most posts begin."""
    return draw.tree.before(draw.motions[0].at, "$OUT[1] = FALSE", "$OUT[2] = FALSE")


@rule("build", "legal")
def lines_of_the_spline_kind(draw: Draw) -> Tree:
    """SLIN for a LIN that ends exactly."""
    m = draw.motion(lambda m: m.node.kind == "lin" and not m.node.tail)
    return draw.tree.put(m.at, f"SLIN {m.node.points[0]}")


@rule("build", "legal")
def the_wait_that_stops_the_advance_run(draw: Draw) -> Tree:
    """WAIT SEC 0 in the air."""
    m = draw.motion(lambda m: m.own and not m.node.tail)
    return draw.tree.after(m.at, "WAIT SEC 0")


@rule("build", "legal")
def override_at_full(draw: Draw) -> Tree:
    return draw.tree.before(draw.motions[0].at, "$OV_PRO = 100")


@rule("build", "legal")
def another_turn_of_the_table_throughout(draw: Draw) -> Tree:
    """E2 is endless: every pose a whole turn on, HOME as it was."""
    changes = {
        m.at: [m.node.with_points(*(p.moved(E2=360.0) for p in m.node.points))] for m in draw.motions if not m.node.axes
    }
    return draw.tree.edit(changes)


@rule("build", "legal")
def a_fresh_approach_in_two_steps(draw: Draw) -> Tree:
    """The entry by PTP, then the same pose by LIN."""
    m = draw.motion(lambda m: m.node.kind == "ptp" and not m.node.axes)
    again = parse(f"LIN {m.node.points[0].without('S', 'T')}")
    return draw.tree.after(m.at, "$VEL.CP = 0.100000", again)


@rule("build", "open")
def exact_stops_everywhere(draw: Draw) -> Tree:
    """No rounding at all: the path is closer, the tool stands at each point for a moment."""
    return draw.tree.edit({m.at: [m.node.with_points(*m.node.points, tail="")] for m in draw.motions if m.node.tail})


@rule("build", "open")
def an_output_set_again(draw: Draw) -> Tree:
    """To what it is."""
    on = draw.line("set", "$OUT[1]", "TRUE")
    m = draw.next_motion(on, 2)
    return draw.tree.before(m.at, draw.tree.at(on))


@rule("build", "open")
def a_loop_that_is_run_once(draw: Draw) -> Tree:
    m = draw.cut()
    return draw.tree.put(m.at, "FOR I = 1 TO 1", m.node, "ENDFOR")


@rule("build", "open")
def hooks_without_their_comments(draw: Draw) -> Tree:
    """`HALT ;change to tool 1` without the words for the operator."""
    return draw.tree.edit({a: ["HALT"] for a in draw.lines("halt")})


@rule("build", "open")
def the_default_orientation_not_restated(draw: Draw) -> Tree:
    """BAS (#INITMOV,0) sets #VAR and #BASE."""
    return draw.tree.edit({draw.line("set", "$ORI_TYPE"): [], draw.line("set", "$CIRC_TYPE"): []})
