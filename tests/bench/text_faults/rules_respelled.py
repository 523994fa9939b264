"""Legal rewrites of single lines: the same values in another spelling. All have to pass."""

from __future__ import annotations

import re
from collections.abc import Callable

from text_faults.context import Draw, NothingToDrawError
from text_faults.rules import rule
from text_faults.tree import Node, Point, Tree, decimals


def _every(draw: Draw, change: Callable[[Node], Node | str | None]) -> Tree:
    """Every line of the .src files through a function that gives None for what stays."""
    changes = {}
    for at in draw.order:
        new = change(draw.tree.at(at))
        if new is not None:
            changes[at] = [new]
    if not changes:
        raise NothingToDrawError
    return draw.tree.edit(changes)


def _poses(draw: Draw, change: Callable[[Point], Point]) -> Tree:
    """Every pose of every motion through a function."""
    return _every(draw, lambda n: n.with_points(*map(change, n.points)) if n.moves and not n.axes else None)


def _code(draw: Draw, change: Callable[[str], str]) -> Tree:
    """The code of every line, without its comment, through a function."""

    def changed(node: Node) -> str | None:
        if node.kind in ("comment", "fold", "endfold", "header", "blank"):
            return None
        code, mark, rest = node.text.partition(";")
        return change(code) + mark + rest

    return _every(draw, changed)


@rule("spelling", "legal")
def blank_lines(draw: Draw) -> Tree:
    some = draw.rng.sample(draw.order[6:], 8)
    return draw.tree.edit({a: ["", draw.tree.at(a), "   "] for a in some})


@rule("spelling", "legal")
def blanks_before_and_behind(draw: Draw) -> Tree:
    return _every(draw, lambda n: f"  {n.text}  " if n.kind not in ("header", "def", "end") else None)


@rule("spelling", "legal")
def tabs_before(draw: Draw) -> Tree:
    return _every(draw, lambda n: f"\t{n.text}" if n.moves or n.kind in ("set", "wait") else None)


@rule("spelling", "legal")
def small_letters(draw: Draw) -> Tree:
    return _code(draw, str.lower)


@rule("spelling", "legal")
def capitals(draw: Draw) -> Tree:
    return _code(draw, str.upper)


@rule("spelling", "legal")
def no_blanks_around_signs(draw: Draw) -> Tree:
    return _every(draw, lambda n: re.sub(r" = ", "=", n.text) if n.kind == "set" and ";" not in n.text else None)


@rule("spelling", "legal")
def many_blanks_around_signs(draw: Draw) -> Tree:
    return _every(draw, lambda n: re.sub(r" = ", "  =   ", n.text) if n.kind == "set" and ";" not in n.text else None)


@rule("spelling", "legal")
def calls_without_blanks(draw: Draw) -> Tree:
    return _every(draw, lambda n: n.text.replace(" ", "") if n.kind in ("bas", "call") else None)


@rule("spelling", "legal")
def truth_in_small_letters(draw: Draw) -> Tree:
    return _every(draw, lambda n: n.text.replace("TRUE", "true").replace("FALSE", "False") if n.kind == "set" else None)


@rule("spelling", "legal")
def comments_added(draw: Draw) -> Tree:
    some = draw.rng.sample(draw.order[6:], 6)
    texts = ["; a remark", ";LIN {X 1.0,Y 2.0,Z 3.0}", ";$VEL.CP = 3.0", "; HALT", ";  END", ";GOTO 7"]
    return draw.tree.edit({a: [text, draw.tree.at(a)] for a, text in zip(some, texts, strict=True)})


@rule("spelling", "legal")
def comments_behind_statements(draw: Draw) -> Tree:
    def remarked(node: Node) -> str | None:
        plain = node.moves or node.kind in ("set", "wait", "bas", "call", "end")
        return f"{node.text} ; {node.kind} {{X 9.0}}" if plain and ";" not in node.text else None

    return _every(draw, remarked)


@rule("spelling", "legal")
def comments_taken_out(draw: Draw) -> Tree:
    return draw.tree.edit({a: [] for a in draw.lines("comment")})


@rule("spelling", "legal")
def folds_added(draw: Draw) -> Tree:
    """Two inline forms as a panel writes them, around a motion each."""
    changes = {}
    for m in draw.rng.sample(draw.motions[1:-1], 2):
        title = (
            f";FOLD LIN P{m.index} CONT Vel=0.1 m/s CPDAT1 Tool[1] Base[0];%{{PE}}%R 8.3.29,%MKUKATPBASIS,%CMOVE,%VLIN"
        )
        changes[m.at] = [title, m.node, ";ENDFOLD"]
    return draw.tree.edit(changes)


@rule("spelling", "legal")
def folds_taken_out(draw: Draw) -> Tree:
    return draw.tree.edit({a: [] for a in (*draw.lines("fold"), *draw.lines("endfold"))})


@rule("spelling", "legal")
def header_lines_taken_out(draw: Draw) -> Tree:
    return draw.tree.edit({a: [] for a in draw.lines("header")})


@rule("spelling", "legal")
def other_header_lines(draw: Draw) -> Tree:
    first, second = draw.lines("header")[:2]
    return draw.tree.edit({first: ["&ACCESS RVO1"], second: ["&REL 27", "&COMMENT edited on the panel"]})


@rule("spelling", "legal")
def points_without_their_type(draw: Draw) -> Tree:
    """`LIN {X ..}` and `PTP {A1 ..}`, as most posts write them."""
    return _every(draw, lambda n: n.with_points(*(Point("", p.fields) for p in n.points)) if n.moves else None)


@rule("spelling", "legal")
def points_of_their_type_in_small_letters(draw: Draw) -> Tree:
    return _every(
        draw, lambda n: n.text.replace("E6POS:", "e6pos :").replace("E6AXIS:", "E6Axis :") if n.moves else None
    )


@rule("spelling", "legal")
def components_in_another_order(draw: Draw) -> Tree:
    return _poses(draw, lambda p: Point(p.kind, tuple(draw.rng.sample(p.fields, len(p.fields)))))


@rule("spelling", "legal")
def blanks_within_points(draw: Draw) -> Tree:
    return _every(draw, lambda n: n.text.replace(",", " , ").replace("{", "{ ").replace("}", " }") if n.moves else None)


@rule("spelling", "legal")
def no_blank_behind_the_type(draw: Draw) -> Tree:
    return _every(draw, lambda n: n.text.replace(": ", ":") if n.moves else None)


@rule("spelling", "legal")
def more_decimals(draw: Draw) -> Tree:
    return _poses(draw, lambda p: Point(p.kind, tuple((n, t + "000" if "." in t else t) for n, t in p.fields)))


@rule("spelling", "legal")
def no_needless_zeros(draw: Draw) -> Tree:
    def short(text: str) -> str:
        return (text.rstrip("0").rstrip(".") or "0") if "." in text else text

    return _poses(draw, lambda p: Point(p.kind, tuple((n, short(t)) for n, t in p.fields)))


@rule("spelling", "legal")
def a_thousandth_of_a_degree(draw: Draw) -> Tree:
    """Angles with three decimals: less than the tolerance."""

    def rounded(p: Point) -> Point:
        return Point(p.kind, tuple((n, f"{float(t):.3f}" if n in "ABC" else t) for n, t in p.fields))

    return _poses(draw, rounded)


@rule("spelling", "legal")
def numbers_with_exponents(draw: Draw) -> Tree:
    def exponent(p: Point) -> Point:
        return Point(p.kind, tuple((n, f"{float(t):.6E}" if n in "XYZ" else t) for n, t in p.fields))

    return _poses(draw, exponent)


@rule("spelling", "legal")
def minus_nought(draw: Draw) -> Tree:
    return _poses(
        draw,
        lambda p: Point(p.kind, tuple((n, "-" + t if float(t) == 0.0 and t[0] != "-" else t) for n, t in p.fields)),
    )


@rule("spelling", "legal")
def status_and_turn_as_bits(draw: Draw) -> Tree:
    def bits(node: Node) -> str | None:
        if node.kind != "ptp" or node.axes:
            return None
        text = re.sub(r"\bS (\d+)", lambda f: f"S 'B{int(f[1]):03b}'", node.text)
        return re.sub(r"\bT (\d+)", lambda f: f"T 'B{int(f[1]):06b}'", text)

    return _every(draw, bits)


@rule("spelling", "legal")
def status_and_turn_on_lines_too(draw: Draw) -> Tree:
    """LIN and CIRC take no notice of S and T."""

    def added(node: Node) -> Node | None:
        if node.kind not in ("lin", "circ"):
            return None
        return node.with_points(
            *(Point(p.kind, (*p.fields[:6], ("S", "2"), ("T", "35"), *p.fields[6:])) for p in node.points)
        )

    return _every(draw, added)


@rule("spelling", "legal")
def all_six_external_axes(draw: Draw) -> Tree:
    """E3 to E6 at 0, which the cell has not."""
    more = tuple((f"E{k}", "0.0") for k in (3, 4, 5, 6))
    return _every(
        draw, lambda n: n.with_points(*(Point(p.kind, (*p.fields, *more)) for p in n.points)) if n.moves else None
    )


@rule("spelling", "legal")
def angles_a_turn_on(draw: Draw) -> Tree:
    def turned(p: Point) -> Point:
        name = draw.rng.choice("AC")
        return p.moved(**{name: draw.rng.choice([-360.0, 360.0])})

    m = draw.lin()
    return draw.tree.put(m.at, m.node.with_points(*map(turned, m.node.points)))


@rule("spelling", "legal")
def the_other_three_angles(draw: Draw) -> Tree:
    """A + 180, 180 - B, C + 180 is the same rotation."""

    def other(p: Point) -> Point:
        a, b, c = (p.values[k] for k in "ABC")
        turned = ((a + 360.0) % 360.0 - 180.0, 180.0 - b, (c + 360.0) % 360.0 - 180.0)
        for name, value in zip("ABC", turned, strict=True):
            p = p.put(name, f"{value:.4f}")
        return p

    return _every(draw, lambda n: n.with_points(*map(other, n.points)) if n.kind in ("lin", "circ") else None)


@rule("spelling", "legal")
def unchanged_components_left_out(draw: Draw) -> Tree:
    """A missing component keeps its value."""
    changes = {}
    for m in draw.motions:
        if m.node.kind == "lin" and m.last:
            texts = dict(m.node.points[0].fields)
            same = [n for n in texts if n in m.last and m.last[n] == float(texts[n])]
            if same and len(same) < len(texts):
                changes[m.at] = [m.node.with_points(m.node.points[0].without(*same))]
    if not changes:
        raise NothingToDrawError
    return draw.tree.edit(changes)


@rule("spelling", "legal")
def frames_with_their_type(draw: Draw) -> Tree:
    return _every(draw, lambda n: n.text.replace("{X", "{FRAME: X") if n.name in ("$TOOL", "$BASE") else None)


@rule("spelling", "legal")
def frames_in_another_order(draw: Draw) -> Tree:
    def turned(node: Node) -> str | None:
        if node.name not in ("$TOOL", "$BASE"):
            return None
        return re.sub(r"\{([^{}]*)\}", lambda f: "{" + ",".join(reversed(f[1].split(","))) + "}", node.text)

    return _every(draw, turned)


@rule("spelling", "legal")
def frames_with_other_decimals(draw: Draw) -> Tree:
    def spelled(node: Node) -> str | None:
        if node.name not in ("$TOOL", "$BASE"):
            return None
        return re.sub(r"-?\d+\.\d+", lambda f: f"{float(f[0]):.4f}" if decimals(f[0]) == 5 else f[0], node.text)

    return _every(draw, spelled)


@rule("spelling", "legal")
def waits_with_other_decimals(draw: Draw) -> Tree:
    return _every(draw, lambda n: f"WAIT SEC {float(n.value):g}" if n.kind == "wait" else None)


@rule("spelling", "legal")
def speeds_as_a_product(draw: Draw) -> Tree:
    return _every(draw, lambda n: f"$VEL.CP = {float(n.value) / 2:.7f}*2" if n.name == "$VEL.CP" else None)


@rule("spelling", "legal")
def speeds_as_a_quotient(draw: Draw) -> Tree:
    return _every(draw, lambda n: f"$VEL.CP = {float(n.value) * 60:.5f} / 60.0" if n.name == "$VEL.CP" else None)


@rule("spelling", "legal")
def speeds_with_exponents(draw: Draw) -> Tree:
    return _every(draw, lambda n: f"$VEL.CP = {float(n.value):.5E}" if n.name == "$VEL.CP" else None)


@rule("spelling", "legal")
def spindle_speed_as_one_number(draw: Draw) -> Tree:
    def worked_out(node: Node) -> str | None:
        if node.name != "$ANOUT[1]":
            return None
        rpm, most = node.value.split(" / ")
        return f"$ANOUT[1] = {float(rpm) / float(most):.8f}"

    return _every(draw, worked_out)


@rule("spelling", "legal")
def spindle_speed_as_another_quotient(draw: Draw) -> Tree:
    def respelled(node: Node) -> str | None:
        if node.name != "$ANOUT[1]":
            return None
        rpm, most = node.value.split(" / ")
        return f"$ANOUT[1] = {float(rpm) / 2:.1f}/{float(most) / 2:.1f}"

    return _every(draw, respelled)
