"""Motions: dropped, doubled, moved, swapped, turned round, of another kind; arcs; approximate positioning."""

from __future__ import annotations

import numpy as np

from text_faults.context import Draw, Motion, NothingToDrawError
from text_faults.rules import rule
from text_faults.tree import At, Node, Point, Tree


@rule("motions", times=3)
def a_motion_dropped(draw: Draw) -> Tree:
    return draw.tree.put(draw.motion(lambda m: not m.own).at)


@rule("motions", times=2)
def two_motions_swapped(draw: Draw) -> Tree:
    m = draw.motion(lambda m: not m.own)
    after = draw.next_motion(m.at)
    if after.own or not (m.cut or after.cut):
        raise NothingToDrawError
    return draw.tree.edit({m.at: [after.node], after.at: [m.node]})


@rule("motions", times=2)
def a_motion_moved(draw: Draw) -> Tree:
    m = draw.motion(lambda m: not m.own)
    to = draw.next_motion(m.at, draw.rng.choice([2, 3]))
    if to.at.file == m.at.file:
        return draw.tree.edit({m.at: [], to.at: [to.node, m.node]})
    return draw.tree.put(m.at).after(to.at, m.node)


@rule("motions")
def a_motion_repeated_later(draw: Draw) -> Tree:
    """A cut's point once more, two motions on: there and back through the part."""
    m = draw.motion(lambda m: m.cut)
    return draw.tree.after(draw.next_motion(m.at, 2).at, m.node)


@rule("motions")
def a_circ_doubled(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ")
    return draw.tree.put(m.at, m.node, m.node)


@rule("motions")
def a_run_of_motions_reversed(draw: Draw) -> Tree:
    run = draw.run()
    nodes = [m.node for m in run][::-1]
    return draw.tree.edit({m.at: [n] for m, n in zip(run, nodes, strict=True)})


@rule("motions")
def a_run_of_motions_dropped(draw: Draw) -> Tree:
    return draw.tree.edit({m.at: [] for m in draw.run()})


@rule("motions")
def a_region_doubled(draw: Draw) -> Tree:
    """The cut with its way in and out, twice."""
    run = draw.run()
    file = run[0].at.file
    first = max(
        [m.at.index for m in draw.motions if m.at.file == file and m.index < run[0].index and not m.cut], default=-1
    )
    last = min([m.at.index for m in draw.motions if m.at.file == file and m.index > run[-1].index], default=-1)
    if first < 0 or last < 0:
        raise NothingToDrawError
    block = [n for n in draw.tree.files[file][first : last + 1] if n.kind not in ("fold", "endfold")]
    return draw.tree.after(type(run[0].at)(file, last), *block)


@rule("motions")
def a_region_of_another_program(draw: Draw) -> Tree:
    """Cutting motions of another job, with their speeds, behind a motion in the air."""
    name = draw.pick([n for n in draw.others if n != draw.name])
    other = draw.others[name]
    lines = [other.at(a) for a in other.order()]
    speeds = [k for k, n in enumerate(lines) if n.name == "$VEL.CP"]
    block = [n for n in lines[speeds[0] : speeds[-1]] if n.moves or n.name == "$VEL.CP"]
    here = draw.motion(lambda m: m.own and m.node.kind == "lin")
    return draw.tree.after(here.at, *block)


@rule("motions")
def a_motion_of_another_program(draw: Draw) -> Tree:
    name = draw.pick([n for n in draw.others if n != draw.name])
    other = draw.others[name]
    foreign = draw.pick([n for n in (other.at(a) for a in other.order()) if n.kind == "lin"])
    return draw.tree.after(draw.cut().at, foreign)


@rule("motions")
def home_in_the_middle_of_the_cut(draw: Draw) -> Tree:
    return draw.tree.after(draw.cut().at, draw.pick([m for m in draw.motions if m.node.axes]).node)


@rule("motions")
def the_entry_in_the_middle_of_the_cut(draw: Draw) -> Tree:
    entry = draw.motion(lambda m: m.node.kind == "ptp" and not m.node.axes)
    return draw.tree.after(draw.cut().at, entry.node)


@rule("motions")
def an_extra_point_off_the_line(draw: Draw) -> Tree:
    """Halfway along a cut, 0.1 mm beside it."""
    m = draw.motion(lambda m: m.cut and m.node.kind == "lin" and m.length > 1.0)
    middle = Point(m.node.points[-1].kind, tuple((n, f"{0.5 * (m.end[n] + m.last[n]):.4f}") for n in m.end))
    return draw.tree.before(m.at, m.node.with_points(middle.moved(Z=-0.1)))


@rule("motions")
def a_plunge_between_two_points(draw: Draw) -> Tree:
    """Down by 8 mm and up again, in the middle of the cut."""
    m = draw.motion(lambda m: m.cut and m.node.kind == "lin")
    return draw.tree.after(m.at, m.node.with_points(m.node.points[-1].moved(Z=-8.0)), m.node)


@rule("motions")
def down_in_rapid(draw: Draw) -> Tree:
    """From the rapid's end on to the first point of the cut, still in rapid: the approach's feed line comes later."""
    m = draw.motion(lambda m: m.cut and m.index > 0 and not draw.motions[m.index - 1].cut and not m.own)
    speed = draw.pick([a for a in draw.lines("set", "$VEL.CP") if 0 < draw.place(m.at) - draw.place(a) <= 2])
    return draw.tree.edit({speed: [], m.at: [m.node, draw.tree.at(speed)]})


@rule("motions")
def a_rapid_straight_across(draw: Draw) -> Tree:
    """The retract and the way over are left out: at depth to the next approach in rapid."""
    starts = [m for m in draw.motions if m.cut and m.index > 0 and not draw.motions[m.index - 1].cut]
    if len(starts) < 2:
        raise NothingToDrawError
    first = draw.pick(starts[1:])
    before = [m for m in draw.motions if m.index < first.index and m.cut][-1]
    between = [m for m in draw.motions if before.index < m.index < first.index and m.node.kind == "lin"]
    return draw.tree.edit({m.at: [] for m in between})


@rule("motions")
def lin_to_ptp_in_a_cut(draw: Draw) -> Tree:
    m = draw.lin(cut=True)
    return draw.tree.put(m.at, m.node.with_points(*m.node.points, kind="ptp", tail=""))


@rule("motions", "open")
def lin_to_ptp_in_rapid(draw: Draw) -> Tree:
    """Same ends, another way between them: a rapid of the file that is not straight."""
    m = draw.lin(cut=False)
    return draw.tree.put(m.at, m.node.with_points(*m.node.points, kind="ptp", tail=""))


@rule("motions", "open")
def entry_as_lin(draw: Draw) -> Tree:
    """From HOME by a straight line, without a speed of its own."""
    m = draw.motion(lambda m: m.node.kind == "ptp" and not m.node.axes)
    return draw.tree.put(m.at, m.node.with_points(m.node.points[0].without("S", "T"), kind="lin"))


@rule("motions", "wrong")
def lin_rel_for_lin(draw: Draw) -> Tree:
    m = draw.lin()
    return draw.tree.put(m.at, m.node.text.replace("LIN ", "LIN_REL ", 1))


@rule("motions", "wrong")
def a_small_lin_rel_added(draw: Draw) -> Tree:
    step = draw.rng.choice(["{Z -0.5}", "{X 0.05}", "{C 2.0}", "{Z -3.0,E2 5.0}"])
    return draw.tree.after(draw.cut().at, f"LIN_REL {step} {draw.rng.choice(['#BASE', '#TOOL', ''])}".rstrip())


@rule("motions", "wrong")
def ptp_rel_added(draw: Draw) -> Tree:
    return draw.tree.after(
        draw.cut().at, f"PTP_REL {draw.rng.choice(['{A6 30.0}', '{A1 0.5}', '{Z -2.0}', '{E1 -40.0}'])}"
    )


@rule("motions", "wrong")
def a_spline_motion_past_the_point(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "lin" and m.cut)
    point = m.node.points[-1].moved(X=1.5)
    return draw.tree.after(m.at, f"{draw.rng.choice(['SLIN', 'SPTP'])} {point}")


@rule("motions", "wrong")
def a_frame_added_to_the_target(draw: Draw) -> Tree:
    """The geometric operator: `LIN {..} : {Z -1}`."""
    m = draw.lin(cut=True)
    return draw.tree.put(m.at, f"LIN {m.node.points[-1]}:{{X 0.0,Y 0.0,Z -1.0,A 0.0,B 0.0,C 0.0}}")


@rule("motions", "wrong")
def a_spline_through_the_points(draw: Draw) -> Tree:
    """A run of lines as one curve through the same points."""
    run = [m for m in draw.run() if m.node.kind == "lin"]
    changes: dict[At, list[str]] = {m.at: [f"SPL {m.node.points[0]}"] for m in run}
    changes[run[0].at].insert(0, "SPLINE")
    changes[run[-1].at].append("ENDSPLINE")
    return draw.tree.edit(changes)


@rule("arcs")
def via_and_end_swapped(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ")
    return draw.tree.put(m.at, m.node.with_points(*m.node.points[::-1]))


@rule("arcs", times=2)
def via_off_the_arc(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ")
    via = m.node.points[0].moved(**{draw.rng.choice("XYZ"): draw.rng.choice([-1, 1]) * draw.rng.uniform(0.05, 2.0)})
    return draw.tree.put(m.at, m.node.with_points(via, m.node.points[1]))


@rule("arcs")
def the_other_way_round(draw: Draw) -> Tree:
    """Via on the far side of the same circle."""
    m = draw.motion(lambda m: m.node.kind == "circ")
    a, b, c = (np.array([p[k] for k in "XYZ"]) for p in (m.last, m.node.points[0].values, m.end))
    u, v = b - a, c - a
    n = np.cross(u, v)
    centre = a + ((u @ u) * np.cross(v, n) + (v @ v) * np.cross(n, u)) / (2 * (n @ n))
    far = 2 * centre - b
    via = m.node.points[0]
    for name, value in zip("XYZ", far, strict=True):
        via = via.put(name, f"{value:.3f}")
    return draw.tree.put(m.at, m.node.with_points(via, m.node.points[1]))


@rule("arcs")
def lin_for_circ(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ")
    return draw.tree.put(m.at, m.node.with_points(m.node.points[1], kind="lin"))


@rule("arcs")
def both_points_by_lin(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ")
    first, last = (m.node.with_points(p, kind="lin") for p in m.node.points)
    return draw.tree.put(m.at, first, last)


@rule("arcs")
def circ_for_lin(draw: Draw) -> Tree:
    """A bow over a straight cut, 0.3 mm high."""
    m = draw.motion(lambda m: m.cut and m.node.kind == "lin" and m.length > 2.0 and m.end["Z"] == m.last["Z"])
    via = Point("E6POS", tuple((n, f"{0.5 * (m.end[n] + m.last[n]):.4f}") for n in m.end)).moved(Z=0.3)
    return draw.tree.put(m.at, m.node.with_points(via, m.node.points[0], kind="circ"))


@rule("arcs", "wrong", times=2)
def a_ca_angle_added(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ")
    angle = draw.rng.choice(["360.0", "-90.0", "45.0", "450.0", "120"])
    ends = ",".join(map(str, m.node.points))
    return draw.tree.put(m.at, f"CIRC {ends},CA {angle}{m.node.tail}")


@rule("arcs", "wrong")
def circ_rel_for_circ(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ")
    return draw.tree.put(m.at, m.node.text.replace("CIRC ", "CIRC_REL ", 1))


@rule("arcs", "wrong")
def the_arc_without_its_end(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "circ")
    return draw.tree.put(m.at, f"CIRC {m.node.points[0]}{m.node.tail}")


def _starts(draw: Draw) -> list[Motion]:
    """Rapid motions of the file that end where a cut begins, exactly."""
    after = {m.index: m for m in draw.motions}
    return [
        m
        for m in draw.motions
        if m.node.kind == "lin" and not m.cut and not m.node.tail and m.index + 1 in after and after[m.index + 1].cut
    ]


def _rounded(node: Node) -> Node:
    return node.with_points(*node.points, tail=" C_DIS")


@rule("rounding", "wrong")
def rapid_rounded_into_the_cut(draw: Draw) -> Tree:
    m = draw.pick(_starts(draw))
    return draw.tree.put(m.at, _rounded(m.node))


@rule("rounding", "open")
def a_corner_rounded_where_an_event_stands(draw: Draw) -> Tree:
    """WAIT, HALT and outputs stop the advance run: the controller does not round there, whatever is written."""
    stops = [
        a for a in draw.order if draw.tree.at(a).kind in ("wait", "halt") or draw.tree.at(a).name.startswith("$OUT")
    ]
    exact = [draw.last_motion(a) for a in stops[4:]]
    m = draw.pick([m for m in exact if m.node.kind == "lin" and not m.node.tail])
    return draw.tree.put(m.at, _rounded(m.node))


@rule("rounding", "open")
def the_end_of_the_cut_rounded(draw: Draw) -> Tree:
    """C_DIS where a cut goes over into the retract, as at the corners within."""
    after = {m.index: m for m in draw.motions}
    ends = [m for m in draw.motions if m.cut and not m.node.tail and not after[m.index + 1].cut]
    return draw.tree.put((m := draw.pick(ends)).at, _rounded(m.node))


@rule("rounding", "wrong", times=2)
def a_large_rounding(draw: Draw) -> Tree:
    value = draw.rng.choice(["5.000", "25.000", "100.0", "8.0"])
    return draw.tree.put(draw.line("set", "$APO.CDIS"), f"$APO.CDIS = {value}")


@rule("rounding", "wrong")
def a_large_rounding_in_the_cut(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.cut and m.node.tail == " C_DIS")
    return draw.tree.before(m.at, f"$APO.CDIS = {draw.rng.choice(['6.0', '30.0'])}")


@rule("rounding", "open")
def rounding_by_speed(draw: Draw) -> Tree:
    """C_VEL with its default: how far it rounds is not written anywhere."""
    m = draw.motion(lambda m: m.cut and m.node.tail == " C_DIS")
    return draw.tree.put(m.at, m.node.with_points(*m.node.points, tail=f" {draw.rng.choice(['C_VEL', 'C_ORI'])}"))
