"""What acts elsewhere than it stands: triggers, interrupts, signals, variables, point lists."""

from __future__ import annotations

from text_faults.context import Draw
from text_faults.rules import rule
from text_faults.tree import At, Tree


def _declared(draw: Draw, declarations: list[str], at: At, *lines: str) -> Tree:
    """Declarations behind DEF and lines before a place of the main file or another."""
    head = next(a for a in draw.order if draw.tree.at(a).kind == "def" and a.file == at.file)
    return draw.tree.edit({head: [draw.tree.at(head), *declarations], at: [*lines, draw.tree.at(at)]})


def _coolant(draw: Draw, at: At) -> str:
    """The coolant switched to what it is not at this place."""
    before = [a for a in draw.lines("set", "$OUT[2]") if draw.place(a) < draw.place(at)]
    return "$OUT[2] = " + ("FALSE" if before and draw.tree.at(before[-1]).value == "TRUE" else "TRUE")


@rule("hidden", "wrong", times=3)
def a_trigger(draw: Draw) -> Tree:
    cut = draw.cut()
    act = draw.rng.choice(
        [
            "$OUT[1] = FALSE",
            _coolant(draw, cut.at),
            "$ANOUT[1] = 0.1",
            "$OUT[9] = TRUE",
            "PULSE($OUT[1],FALSE,1.0)",
            "LOWER ( ) PRIO = -1",
        ]
    )
    when = draw.rng.choice(["DISTANCE=0 DELAY=0", "DISTANCE=1 DELAY=-20", "PATH=-5 DELAY=0", "PATH=0 ONSTART DELAY=10"])
    return draw.tree.before(cut.at, f"TRIGGER WHEN {when} DO {act}")


@rule("hidden", "wrong", times=3)
def an_interrupt(draw: Draw) -> Tree:
    cut = draw.cut()
    act = draw.rng.choice(["$OUT[1] = FALSE", "AWAY ( )", _coolant(draw, cut.at), "$VEL.CP = 0.2", "BRAKE"])
    when = draw.rng.choice(["$IN[1]==TRUE", "$DIST_NEXT<5", "$TIMER[1]>100", "$STOPMESS==TRUE", "$IN[3]"])
    word = draw.rng.choice(["INTERRUPT DECL", "GLOBAL INTERRUPT DECL"])
    declare = f"{word} {draw.rng.choice([3, 5, 21])} WHEN {when} DO {act}"
    number = declare.split(" DECL ")[1].split()[0]
    return draw.tree.before(cut.at, declare, f"INTERRUPT ON {number}")


@rule("hidden", "wrong")
def an_interrupt_with_a_routine_that_moves(draw: Draw) -> Tree:
    made = draw.tree.before(draw.cut().at, "INTERRUPT DECL 4 WHEN $IN[1]==TRUE DO AWAY ( )", "INTERRUPT ON 4")
    return made.after(made.lines_of_end(made.main), "DEF AWAY ( )", "BRAKE", "LIN_REL {Z -30.0}", "END")


@rule("hidden", "wrong", times=2)
def a_signal(draw: Draw) -> Tree:
    """An output under a name of its own, switched in the cut."""
    cut = draw.cut()
    wet = _coolant(draw, cut.at).replace("$OUT[2]", "WET")
    declare, use = draw.rng.choice(
        [
            ("SIGNAL MILL $OUT[1]", "MILL = FALSE"),
            ("SIGNAL WET $OUT[2]", wet),
            ("SIGNAL RPM $ANOUT[1]", "RPM = 0.05"),
            ("SIGNAL BOTH $OUT[1] TO $OUT[2]", "BOTH = 0"),
            ("SIGNAL LAMP $OUT[1]", "PULSE(LAMP,FALSE,0.3)"),
        ]
    )
    return _declared(draw, [declare], cut.at, use)


@rule("hidden", "wrong")
def a_variable_for_a_number(draw: Draw) -> Tree:
    """Another value than the figure that it stands for."""
    m = draw.lin(cut=True)
    x = dict(m.node.points[-1].fields)["X"]
    text = m.node.text.replace(f"X {x}", "X NOWX", 1)
    return _declared(draw, ["DECL REAL NOWX"], m.at, f"NOWX = {float(x) + 0.4:.3f}").put_text(m.node.text, text)


@rule("hidden", "wrong")
def a_speed_by_a_variable(draw: Draw) -> Tree:
    at = draw.pick([a for a in draw.lines("set", "$VEL.CP") if float(draw.tree.at(a).value) < 0.1])
    value = float(draw.tree.at(at).value) * draw.rng.choice([3.0, 0.3, 1000.0])
    return _declared(draw, ["DECL REAL FEED"], at, f"FEED = {value:.6f}").put_text(
        draw.tree.at(at).text, "$VEL.CP = FEED"
    )


@rule("hidden", "wrong", times=2)
def a_point_variable_changed(draw: Draw) -> Tree:
    """The point is right where it is set, and moved before it is used."""
    m = draw.lin(cut=True)
    change = draw.rng.choice(
        ["XNOW.Z = XNOW.Z - 0.5", "XNOW.X = 3.0", "XNOW.A = 0.0\r\nXNOW.B = 20.0", "XNOW.E1 = 1900.0"]
    )
    lines = ["XNOW = " + str(m.node.points[-1]), *change.split("\r\n")]
    return _declared(draw, ["DECL E6POS XNOW"], m.at, *lines).put_text(m.node.text, f"LIN XNOW{m.node.tail}")


@rule("hidden", "wrong")
def a_point_of_the_list_moved(draw: Draw) -> Tree:
    """A motion by a name; the .dat beside it has the point 0.3 mm off."""
    m = draw.lin(cut=True)
    moved = m.node.points[-1].moved(**{draw.rng.choice("XYZ"): 0.3})
    return draw.tree.put(m.at, f"LIN XP7{m.node.tail}").in_list(f"DECL E6POS XP7={str(moved).replace('E6POS: ', '')}")


@rule("hidden", "wrong")
def a_point_of_the_list_missing(draw: Draw) -> Tree:
    return draw.tree.put(draw.lin(cut=True).at, "LIN XP99")


@rule("hidden", "wrong")
def a_point_of_the_list_twice(draw: Draw) -> Tree:
    m = draw.lin(cut=True)
    good, bad = m.node.points[-1], m.node.points[-1].moved(Z=-1.0)
    both = [f"DECL E6POS XP7={str(p).replace('E6POS: ', '')}" for p in (good, bad)]
    return draw.tree.put(m.at, f"LIN XP7{m.node.tail}").in_list(*both)


@rule("hidden", "wrong")
def home_by_a_name_that_says_otherwise(draw: Draw) -> Tree:
    """XHOME in the program's .dat: the wrist in the table's pedestal."""
    m = draw.motion(lambda m: m.node.axes)
    bad = "{A1 0.0,A2 0.0,A3 120.0,A4 0.0,A5 30.0,A6 0.0,E1 0.0,E2 0.0}"
    return draw.tree.put(m.at, "PTP XHOME").in_list(f"DECL E6AXIS XHOME={bad}")


@rule("hidden", "wrong")
def home_by_a_name_that_is_not_at_hand(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.node.axes)
    return draw.tree.put(m.at, draw.rng.choice(["PTP XHOME", "PTP XHOME2", "PTP $H_POS", "PTP $AXIS_RET"]))


@rule("hidden", "wrong")
def to_where_it_happens_to_stand(draw: Draw) -> Tree:
    """A motion in the cut to a place that no text knows."""
    line = draw.rng.choice(
        ["PTP $AXIS_FOR", "LIN $POS_BACK", "LIN $POS_RET", "PTP $AXIS_INT", "LIN $NULLFRAME", "PTP $POS_INT"]
    )
    return draw.tree.before(draw.cut().at, line)


@rule("hidden", "wrong")
def the_output_by_a_routine(draw: Draw) -> Tree:
    """A local function that switches the spindle, in place of a speed."""
    at = draw.pick([a for a in draw.lines("set", "$VEL.CP") if float(draw.tree.at(a).value) < 0.1])
    made = draw.tree.put(at, "$VEL.CP = SLOW(1)")
    body = ["DEFFCT REAL SLOW(N :IN)", "INT N", "$OUT[1] = FALSE", f"RETURN {draw.tree.at(at).value}", "ENDFCT"]
    return made.after(made.lines_of_end(made.main), *body)


@rule("hidden", "wrong")
def an_output_in_the_data_list(draw: Draw) -> Tree:
    return draw.tree.in_list("SIGNAL SPINDLE_ON $OUT[1]", "DECL GLOBAL REAL SPEED = 3.0").before(
        draw.cut().at, "SPINDLE_ON = FALSE"
    )


@rule("hidden", "wrong")
def a_submit_program_started(draw: Draw) -> Tree:
    line = draw.rng.choice(['CWRITE($CMD,ST,M,"RUN /R1/OTHER()")', 'CWRITE($FCT_CALL,ST,M,"krl_fopen")', "SPS ( )"])
    return draw.tree.before(draw.cut().at, line)
