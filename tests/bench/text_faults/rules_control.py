"""The flow of control: jumps, loops, conditions, routines, files, and lines that are none any more."""

from __future__ import annotations

from text_faults.context import Draw, NothingToDrawError
from text_faults.rules import rule
from text_faults.tree import At, Tree


def _stretch(draw: Draw) -> tuple[At, At]:
    """First and last line of some lines with a motion of the cut among them, in one file."""
    m = draw.motion(lambda m: m.cut)
    last = draw.next_motion(m.at, draw.rng.choice([1, 2]))
    return m.at, last.at if last.at.file == m.at.file else m.at


def _around(draw: Draw, before: list[str], after: list[str]) -> Tree:
    first, last = _stretch(draw)
    if first == last:
        return draw.tree.put(first, *before, draw.tree.at(first), *after)
    return draw.tree.edit({first: [*before, draw.tree.at(first)], last: [draw.tree.at(last), *after]})


def _event(draw: Draw) -> At:
    """A line that starts or stops something."""
    return draw.pick(
        [a for a in draw.order if draw.tree.at(a).name in ("$OUT[1]", "$OUT[2]") and ";" not in draw.tree.at(a).text]
    )


@rule("flow", times=2)
def jumped_over(draw: Draw) -> Tree:
    return _around(draw, ["GOTO PAST"], ["PAST:"])


@rule("flow")
def if_false_around_motions(draw: Draw) -> Tree:
    return _around(draw, ["IF FALSE THEN"], ["ENDIF"])


@rule("flow", "wrong", times=2)
def a_condition_around_motions(draw: Draw) -> Tree:
    test = draw.rng.choice(["$IN[3]", "$IN[3]==TRUE", "$OUT[5]", "I>3", "NOT $IN[7]", "$T1", "1>2", "$MODE_OP==#T1"])
    return _around(draw, [f"IF {test} THEN"], ["ENDIF"])


@rule("flow", "wrong")
def the_motions_in_else(draw: Draw) -> Tree:
    return _around(draw, ["IF TRUE THEN", "ELSE"], ["ENDIF"])


@rule("flow", "wrong")
def a_condition_around_an_event(draw: Draw) -> Tree:
    at = _event(draw)
    return draw.tree.put(at, f"IF {draw.rng.choice(['$IN[1]', '$T1', 'FALSE'])} THEN", draw.tree.at(at), "ENDIF")


@rule("flow")
def a_loop_around_motions(draw: Draw) -> Tree:
    first, last = _stretch(draw)
    if first == last:
        raise NothingToDrawError
    nodes = {first: ["FOR I = 1 TO 2", draw.tree.at(first)], last: [draw.tree.at(last), "ENDFOR"]}
    return draw.tree.edit(nodes)


@rule("flow", "wrong", times=2)
def another_loop_around_motions(draw: Draw) -> Tree:
    before, after = draw.rng.choice(
        [
            ("WHILE $IN[2]", "ENDWHILE"),
            ("REPEAT", "UNTIL $IN[2]"),
            ("LOOP", "ENDLOOP"),
            ("FOR I = 1 TO N", "ENDFOR"),
            ("FOR I = 3 TO 1", "ENDFOR"),
            ("SWITCH $MODE_OP\r\nCASE #T1", "ENDSWITCH"),
            ("WHILE FALSE", "ENDWHILE"),
            ("FOR I = 1 TO 3 STEP 1", "ENDFOR"),
        ]
    )
    return _around(draw, before.split("\r\n"), [after])


@rule("flow", "wrong")
def back_to_the_start(draw: Draw) -> Tree:
    """Endless: the program never comes to its end."""
    entry = draw.motion(lambda m: m.node.kind == "ptp" and not m.node.axes)
    end = [a for a in draw.lines("end") if a.file == entry.at.file][-1]
    return draw.tree.edit({entry.at: ["AGAIN:", entry.node], end: ["GOTO AGAIN", draw.tree.at(end)]})


@rule("flow")
def returned_early(draw: Draw) -> Tree:
    return draw.tree.before(draw.cut().at, "RETURN")


@rule("flow", "wrong", times=2)
def ended_early(draw: Draw) -> Tree:
    """END, or what ends a program, in the middle of the cut."""
    at = draw.cut().at
    return draw.tree.before(
        at, draw.rng.choice(["END", "EXIT", "CANCEL PROGRAM", "HALT\r\nEND", "RESUME"]).replace("\r\n", " ")
    )


@rule("flow", "wrong")
def cut_off(draw: Draw) -> Tree:
    """The file ends in the middle, no END."""
    m = draw.cut()
    text = "".join(n.text + "\r\n" for n in draw.tree.files[m.at.file][: m.at.index])
    return draw.tree.with_file(m.at.file, text)


@rule("comments", times=2)
def a_motion_commented_out(draw: Draw) -> Tree:
    m = draw.motion(lambda m: not m.own)
    return draw.tree.put(m.at, ";" + m.node.text)


@rule("comments")
def an_event_commented_out(draw: Draw) -> Tree:
    at = _event(draw)
    return draw.tree.put(at, f"; {draw.tree.at(at).text}")


@rule("comments", "wrong")
def a_setting_commented_out(draw: Draw) -> Tree:
    at = draw.rng.choice([draw.line("set", "$TOOL"), draw.line("set", "$BASE"), draw.line("set", "$ACT_EX_AX")])
    return draw.tree.put(at, f";{draw.tree.at(at).text}")


@rule("comments", "open")
def the_initialisation_commented_out(draw: Draw) -> Tree:
    """BAS (#INITMOV,0): all that the program doesn't set itself is what the last program left."""
    at = draw.lines("bas")[0]
    return draw.tree.put(at, f";{draw.tree.at(at).text}")


@rule("comments")
def the_end_of_a_fold_swallowed(draw: Draw) -> Tree:
    """A fold's title and the motion behind it in one line, which is a comment."""
    m = draw.motion(lambda m: m.cut)
    return draw.tree.put(m.at, f";FOLD next {m.node.text}")


@rule("comments")
def half_a_line_commented_out(draw: Draw) -> Tree:
    """The approximation's place taken by a comment is none; the coordinates lost in one are."""
    m = draw.motion(lambda m: m.cut and m.node.kind == "lin")
    return draw.tree.put(m.at, m.node.text.replace(",Y", ";,Y", 1))


@rule("routines", "wrong")
def a_call_of_what_is_not_there(draw: Draw) -> Tree:
    call = draw.rng.choice(["CLEAN_TOOL ( )", "grip(1,TRUE)", "MEASURE ()", "SPINDLE(8000)", "TOOL_OFF ( )"])
    return draw.tree.before(draw.cut().at, call)


@rule("routines", "wrong")
def a_local_routine_that_moves(draw: Draw) -> Tree:
    """Called in the cut, defined below the main program."""
    line = draw.rng.choice(["LIN_REL {Z -2.0}", "PTP {A1 10.0}", "$OUT[1] = FALSE", "$VEL.CP = 0.5", "$BASE.Z = -1.0"])
    made = draw.tree.before(draw.cut().at, "HELPER ( )")
    end = made.lines_of_end(made.main)
    return made.after(end, "DEF HELPER ( )", line, "END")


@rule("routines", "wrong")
def bas_of_the_programs_own(draw: Draw) -> Tree:
    """A local BAS hides the controller's."""
    end = draw.tree.lines_of_end(draw.tree.main)
    line = draw.rng.choice(["$OUT[1] = TRUE", "PTP {A1 90.0,A2 0.0}", "$IPO_MODE = #TCP", "$ROBROOT.Z = 20.0"])
    return draw.tree.after(end, "DEF BAS (CMD :IN,VALUE :IN )", "DECL BAS_COMMAND CMD", "REAL VALUE", line, "END")


@rule("routines", "wrong")
def another_routine_first(draw: Draw) -> Tree:
    """The module's first DEF is the one that is run."""
    at = next(a for a in draw.order if draw.tree.at(a).kind == "def")
    home = draw.motions[0].node
    return draw.tree.before(at, "DEF FIRST ( )", "BAS (#INITMOV,0 )", home, "END")


@rule("routines", "wrong")
def the_program_under_another_name(draw: Draw) -> Tree:
    """DEF and file differ in name."""
    at = next(a for a in draw.order if draw.tree.at(a).kind == "def")
    return draw.tree.put(at, "DEF elsewhere ( )")


@rule("routines", only=("split",))
def a_part_hidden_by_a_local_routine(draw: Draw) -> Tree:
    call = draw.line("call")
    end = draw.tree.lines_of_end(draw.tree.main)
    return draw.tree.after(end, f"DEF {draw.tree.at(call).name} ( )", ";nothing left to do", "END")


@rule("routines", only=("split",))
def two_calls_exchanged(draw: Draw) -> Tree:
    a, b = draw.rng.sample(draw.lines("call"), 2)
    return draw.tree.edit({a: [draw.tree.at(b)], b: [draw.tree.at(a)]})


@rule("routines", only=("split",))
def a_call_dropped(draw: Draw) -> Tree:
    return draw.tree.put(draw.line("call"))


@rule("routines", only=("split",))
def a_call_doubled(draw: Draw) -> Tree:
    at = draw.line("call")
    return draw.tree.put(at, draw.tree.at(at), draw.tree.at(at))


@rule("routines", "wrong", only=("split",))
def a_part_missing(draw: Draw) -> Tree:
    return draw.tree.with_file(f"{draw.tree.at(draw.line('call')).name}.src", None)


@rule("routines", only=("split",))
def two_parts_exchanged(draw: Draw) -> Tree:
    """Each under the other's name and DEF."""
    one, two = (draw.tree.at(a).name for a in draw.rng.sample(draw.lines("call"), 2))
    texts = draw.tree.texts()
    a = texts[f"{two}.src"].replace(two, one)
    b = texts[f"{one}.src"].replace(one, two)
    return draw.tree.with_file(f"{one}.src", a).with_file(f"{two}.src", b)


@rule("routines", "wrong", only=("split",))
def a_part_that_defines_another_name(draw: Draw) -> Tree:
    one, two = (draw.tree.at(a).name for a in draw.rng.sample(draw.lines("call"), 2))
    return draw.tree.with_file(f"{one}.src", draw.tree.texts()[f"{two}.src"])


@rule("routines", "wrong", only=("split",))
def a_part_that_calls_itself(draw: Draw) -> Tree:
    name = draw.tree.at(draw.line("call")).name
    file = f"{name}.src"
    end = At(file, len(draw.tree.files[file]) - 1)
    return draw.tree.before(end, f"{name} ( )")


@rule("text", "wrong", times=2)
def a_line_that_is_no_krl(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.cut and m.node.kind == "lin")
    text = m.node.text
    bad = draw.rng.choice(
        [
            text.replace("{", "(", 1),
            text.replace("}", "", 1),
            text.replace("LIN", "LINE", 1),
            text + " C_SOON",
            text.replace(",", ";", 1),
            text.replace("Z ", "Z= ", 1),
            "G1 X10 Y10",
            text + " " + text,
            text[: len(text) // 2],
            text.replace("E6POS", "E7POS", 1),
            text.replace("E6POS", "E6AXIS", 1),
            text.replace("X ", "U ", 1),
        ]
    )
    return draw.tree.put(m.at, bad)


@rule("text", "wrong", times=2)
def a_statement_that_nobody_knows(draw: Draw) -> Tree:
    line = draw.rng.choice(
        [
            "BRAKE",
            "RUN=2",
            'CWRITE($CMD,STAT,MODE,"RUN /R1/OTHER()")',
            "$POS_ACT.X = 3.0",
            "RSI_MOVECORR()",
            "ST_ON()",
            "PTP XHOME C_PTP",
            "MOVE_TO(3)",
            "$CORR_T.Z = 1.0",
            "$DELTAWORKOFF = TRUE",
            "$TECH[1].MODE = #CYCLE",
            "LIN P1 VEL=2 M/S",
        ]
    )
    return draw.tree.before(draw.cut().at, line)


@rule("text", "open", times=2)
def a_setting_of_the_controller(draw: Draw) -> Tree:
    """Nothing that these programs do depends on it."""
    line = draw.rng.choice(
        [
            "$SOFTP_END[1] = 400.0",
            "$LOAD.M = 90.0",
            "$GEAR_JERK[1] = 90",
            "$CYCFLAG[1] = $IN[1]",
            "$FLAG[3] = TRUE",
            "$TIMER_STOP[1] = FALSE",
            "$H_POS = $AXIS_ACT",
            "$VEL_AXIS[1] = 5",
        ]
    )
    return draw.tree.before(draw.cut().at, line)
