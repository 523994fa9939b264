"""Numbers of poses: signs, digits, components of others, track and table, Status and Turn."""

from __future__ import annotations

from text_faults.context import Draw, NothingToDrawError
from text_faults.rules import rule
from text_faults.tree import Point, Tree, decimals


def _end(draw: Draw, motion, point: Point) -> Tree:  # type: ignore[no-untyped-def]
    return draw.tree.put(motion.at, motion.node.with_points(*motion.node.points[:-1], point))


@rule("numbers", times=3)
def sign_of_a_component(draw: Draw) -> Tree:
    m = draw.motion(lambda m: not m.own)
    point = m.node.points[-1]
    name = draw.pick([n for n, t in point.fields if n in "XYZBC" and abs(float(t)) > 0.02])
    return _end(draw, m, point.put(name, f"{-point.values[name]:.{decimals(dict(point.fields)[name])}f}"))


@rule("numbers", times=2)
def two_components_swapped(draw: Draw) -> Tree:
    m = draw.motion(lambda m: not m.own)
    point = m.node.points[-1]
    a, b = draw.rng.sample(["X", "Y", "Z", "B", "C"], 2)
    if abs(point.values[a] - point.values[b]) < 0.02:
        raise NothingToDrawError
    texts = dict(point.fields)
    return _end(draw, m, point.put(a, texts[b]).put(b, texts[a]))


@rule("numbers", times=3)
def some_hundredths_of_a_millimetre(draw: Draw) -> Tree:
    m = draw.lin()
    step = draw.rng.choice([-1, 1]) * draw.rng.uniform(0.02, 0.09)
    return _end(draw, m, m.node.points[-1].moved(**{draw.rng.choice("XYZ"): step}))


@rule("numbers", times=3)
def some_hundredths_of_a_degree(draw: Draw) -> Tree:
    m = draw.lin()
    step = draw.rng.choice([-1, 1]) * draw.rng.uniform(0.03, 0.2)
    return _end(draw, m, m.node.points[-1].moved(**{draw.rng.choice("BC"): step}))


@rule("numbers", times=2)
def a_digit(draw: Draw) -> Tree:
    """One digit of a number changed, not its last."""
    m = draw.motion(lambda m: not m.own)
    point = m.node.points[-1]
    name = draw.rng.choice("XYZBC")
    text = dict(point.fields)[name]
    k = draw.pick([k for k, c in enumerate(text[: text.index(".") + 3]) if c.isdigit()])
    digit = draw.rng.choice([d for d in "0123456789" if d != text[k]])
    return _end(draw, m, point.put(name, text[:k] + digit + text[k + 1 :]))


@rule("numbers", times=2)
def a_component_of_the_next_point(draw: Draw) -> Tree:
    m = draw.lin()
    after = draw.next_motion(m.at)
    if after.node.axes:
        raise NothingToDrawError
    name = draw.pick([n for n in "XYZBC" if abs(m.end[n] - after.end[n]) > 0.05])
    return _end(draw, m, m.node.points[-1].put(name, dict(after.node.points[-1].fields)[name]))


@rule("numbers")
def the_decimal_point_one_place_on(draw: Draw) -> Tree:
    m = draw.lin()
    name = draw.pick([n for n in "XYZ" if abs(m.end[n]) > 0.1])
    value = m.end[name] * draw.rng.choice([10.0, 0.1])
    return _end(draw, m, m.node.points[-1].put(name, f"{value:.3f}"))


@rule("numbers")
def metres_for_millimetres(draw: Draw) -> Tree:
    m = draw.lin(cut=True)
    point = m.node.points[-1]
    for name in "XYZ":
        point = point.put(name, f"{m.end[name] / 1000.0:.6f}")
    return _end(draw, m, point)


@rule("numbers", times=2)
def a_component_left_out_that_changes(draw: Draw) -> Tree:
    """What is left out keeps the last point's value."""
    m = draw.motion(lambda m: m.node.kind == "lin" and not m.own and bool(m.last))
    name = draw.pick([n for n in "XYZBC" if abs(m.end[n] - m.last[n]) > 0.05])
    return _end(draw, m, m.node.points[-1].without(name))


@rule("numbers")
def a_component_written_twice(draw: Draw) -> Tree:
    m = draw.lin(cut=True)
    point = m.node.points[-1]
    again = Point(point.kind, (*point.fields, ("Z", f"{m.end['Z'] - 1.0:.3f}")))
    return _end(draw, m, again)


@rule("numbers")
def no_number_at_all(draw: Draw) -> Tree:
    """`X nan`, a lost figure, a comma for the point."""
    m = draw.lin(cut=True)
    text = dict(m.node.points[-1].fields)["X"]
    bad = draw.rng.choice(["NAN", "", text.replace(".", ","), text.replace(".", ".."), "1E400", "\u00ad" + text])
    return draw.tree.put(m.at, str(m.node.text).replace(f"X {text}", f"X {bad}", 1))


@rule("numbers")
def all_depths_lower(draw: Draw) -> Tree:
    """Every Z of every cut, 0.05 mm."""
    return draw.tree.edit(
        {m.at: [m.node.with_points(*(p.moved(Z=-0.05) for p in m.node.points))] for m in draw.motions if m.cut}
    )


@rule("numbers")
def mirrored_in_x(draw: Draw) -> Tree:
    """X of every CP motion with the other sign."""

    def mirrored(p: Point) -> Point:
        return p.put("X", f"{-p.values['X']:.3f}")

    changes = {m.at: [m.node.with_points(*map(mirrored, m.node.points))] for m in draw.motions if not m.node.axes}
    return draw.tree.edit(changes)


@rule("numbers")
def x_and_y_of_the_whole_program(draw: Draw) -> Tree:
    def swapped(p: Point) -> Point:
        return p.put("X", dict(p.fields)["Y"]).put("Y", dict(p.fields)["X"])

    changes = {m.at: [m.node.with_points(*map(swapped, m.node.points))] for m in draw.motions if not m.node.axes}
    return draw.tree.edit(changes)


@rule("numbers")
def angles_of_the_zyz_order(draw: Draw) -> Tree:
    """A and C exchanged wherever they stand."""

    def swapped(p: Point) -> Point:
        return p.put("A", dict(p.fields)["C"]).put("C", dict(p.fields)["A"])

    changes = {m.at: [m.node.with_points(*map(swapped, m.node.points))] for m in draw.motions if not m.node.axes}
    return draw.tree.edit(changes)


@rule("axes", times=2)
def a_of_one_point(draw: Draw) -> Tree:
    """A roll where the tool stands upright, a lean where it doesn't."""
    m = draw.lin(cut=True)
    return _end(draw, m, m.node.points[-1].moved(A=draw.rng.choice([-1, 1]) * draw.rng.uniform(0.05, 40.0)))


@rule("axes")
def track_beyond_its_end(draw: Draw) -> Tree:
    m = draw.lin()
    return _end(draw, m, m.node.points[-1].put("E1", f"{draw.rng.choice([-1, 1]) * draw.rng.uniform(1501, 4000):.4f}"))


@rule("axes")
def track_out_of_reach(draw: Draw) -> Tree:
    m = draw.lin()
    return _end(draw, m, m.node.points[-1].put("E1", f"{draw.rng.choice([-1, 1]) * draw.rng.uniform(1200, 1490):.4f}"))


@rule("axes")
def table_half_a_turn_on(draw: Draw) -> Tree:
    m = draw.lin(cut=True)
    return _end(draw, m, m.node.points[-1].moved(E2=draw.rng.choice([-1, 1]) * draw.rng.uniform(100.0, 180.0)))


@rule("axes")
def table_a_whole_turn_in_a_cut(draw: Draw) -> Tree:
    m = draw.lin(cut=True)
    return _end(draw, m, m.node.points[-1].moved(E2=draw.rng.choice([-360.0, 360.0])))


@rule("axes")
def track_by_its_sign(draw: Draw) -> Tree:
    m = draw.lin()
    return _end(draw, m, m.node.points[-1].put("E1", f"{-m.end['E1']:.4f}"))


@rule("axes")
def table_by_its_sign(draw: Draw) -> Tree:
    m = draw.lin()
    return _end(draw, m, m.node.points[-1].put("E2", f"{-m.end['E2']:.4f}"))


@rule("axes")
def table_by_its_sign_throughout(draw: Draw) -> Tree:
    def turned(p: Point) -> Point:
        return p.put("E2", f"{-p.values['E2']:.4f}")

    changes = {m.at: [m.node.with_points(*map(turned, m.node.points))] for m in draw.motions if not m.node.axes}
    return draw.tree.edit(changes)


@rule("axes")
def track_and_table_exchanged(draw: Draw) -> Tree:
    m = draw.lin()
    texts = dict(m.node.points[-1].fields)
    return _end(draw, m, m.node.points[-1].put("E1", texts["E2"]).put("E2", texts["E1"]))


@rule("axes")
def an_external_axis_dropped(draw: Draw) -> Tree:
    m = draw.lin()
    return _end(draw, m, m.node.points[-1].without(draw.rng.choice(["E1", "E2"])))


@rule("axes", times=2)
def status(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "ptp" and not m.node.axes)
    bit = draw.rng.choice([1, 2, 4])
    return _end(draw, m, m.node.points[-1].put("S", str(int(m.end["S"]) ^ bit)))


@rule("axes", times=2)
def turn(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.kind == "ptp" and not m.node.axes)
    bit = draw.rng.choice([1, 2, 4, 8, 16, 32])
    return _end(draw, m, m.node.points[-1].put("T", str(int(m.end["T"]) ^ bit)))


@rule("axes", "open")
def no_status_and_turn(draw: Draw) -> Tree:
    """Without S and T the controller takes the shortest way: nothing says which posture that is."""
    m = draw.motion(lambda m: m.node.kind == "ptp" and not m.node.axes)
    return _end(draw, m, m.node.points[-1].without("S", "T"))


@rule("axes")
def axis_beyond_its_range(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.axes)
    name, value = draw.rng.choice(
        [("A1", 200.0), ("A2", 90.0), ("A3", -130.0), ("A4", 355.0), ("A5", 140.0), ("E1", 1600.0)]
    )
    return _end(draw, m, m.node.points[-1].put(name, f"{value:.4f}"))


@rule("axes", "open")
def another_home(draw: Draw) -> Tree:
    """A posture within all limits that is not HOME: other moves in the air."""
    m = draw.motion(lambda m: m.node.axes)
    name, value = draw.rng.choice(
        [("A1", 40.0), ("A3", 70.0), ("A5", -90.0), ("A6", 120.0), ("E1", 200.0), ("E2", 90.0)]
    )
    return _end(draw, m, m.node.points[-1].put(name, f"{value:.4f}"))


@rule("axes", "wrong")
def home_under_the_table(draw: Draw) -> Tree:
    """The forearm through the table's disc, the wrist in its pedestal."""
    m = draw.motion(lambda m: m.node.axes)
    point = m.node.points[-1]
    for name, value in (("A1", 0.0), ("A2", 0.0), ("A3", 120.0), ("A5", 30.0)):
        point = point.put(name, f"{value:.4f}")
    return _end(draw, m, point)


@rule("axes", "wrong")
def the_way_in_through_the_table(draw: Draw) -> Tree:
    """The entry, or the way out, below the table's top."""
    m = draw.motion(lambda m: m.own and not m.node.axes)
    return _end(draw, m, m.node.points[-1].put("Z", f"{-draw.rng.uniform(60.0, 200.0):.3f}"))


@rule("axes", "wrong", times=2, only=("arcs", "tools", "holes", "tilted", "split"))
def the_way_in_or_out_at_depth(draw: Draw) -> Tree:
    """A point of camrob's own, above the part, at the depth of the cut instead."""
    m = draw.motion(lambda m: m.own and not m.node.axes)
    lowest = min(m.end["Z"] for m in draw.motions if m.cut)
    return _end(draw, m, m.node.points[-1].put("Z", f"{lowest:.3f}"))
