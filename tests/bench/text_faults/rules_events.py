"""Process events: spindle, coolant, dwell, stop and tool change, lost, doubled, early, late or with another value."""

from __future__ import annotations

from text_faults.context import Draw, NothingToDrawError
from text_faults.rules import rule
from text_faults.tree import At, Tree


def _on(draw: Draw) -> At:
    """A line that starts the spindle."""
    return draw.line("set", "$OUT[1]", "TRUE")


def _hook(draw: Draw, on: At) -> list[At]:
    """The lines of a spindle's start: its speed, its output, the wait."""
    k = draw.place(on)
    return [draw.order[k - 1], on, draw.order[k + 1]]


def _off(draw: Draw) -> At:
    """A line that stops the spindle in the program's course, not the cell's footer."""
    return draw.pick([a for a in draw.lines("set", "$OUT[1]", "FALSE") if ";" not in draw.tree.at(a).text])


def _moved(draw: Draw, lines: list[At], to: At) -> Tree:
    """Lines taken from where they are and put behind another (of their own file, or not)."""
    nodes = [draw.tree.at(a) for a in lines]
    if to in lines:
        raise NothingToDrawError
    return draw.tree.edit({**{a: [] for a in lines}, to: [draw.tree.at(to), *nodes]})


def _dwells(draw: Draw) -> list[At]:
    """Waits that the file asks for: those behind a motion of a cut."""
    return [a for a in draw.lines("wait") if draw.tree.at(draw.order[draw.place(a) - 1]).moves]


@rule("spindle")
def spindle_output_dropped(draw: Draw) -> Tree:
    return draw.tree.put(_on(draw))


@rule("spindle")
def spindle_speed_dropped(draw: Draw) -> Tree:
    return draw.tree.put(draw.line("set", "$ANOUT[1]"))


@rule("spindle")
def spindle_start_dropped(draw: Draw) -> Tree:
    return draw.tree.edit({a: [] for a in _hook(draw, _on(draw))})


@rule("spindle")
def spindle_starts_in_the_cut(draw: Draw) -> Tree:
    on = _on(draw)
    cut = draw.pick([m for m in draw.motions if m.cut and draw.place(m.at) > draw.place(on)])
    return _moved(draw, _hook(draw, on), cut.at)


@rule("spindle", "wrong")
def spindle_up_to_speed_too_late(draw: Draw) -> Tree:
    """The wait for the speed left out."""
    return draw.tree.put(_hook(draw, _on(draw))[2])


@rule("spindle")
def spindle_at_another_speed(draw: Draw) -> Tree:
    at = draw.line("set", "$ANOUT[1]")
    rpm, rest = draw.tree.at(at).value.split(" / ")
    other = draw.rng.choice([str(int(rpm) + 50), str(int(rpm) // 2), str(int(rpm) * 10), rpm[0], "24000"])
    return draw.tree.put(at, f"$ANOUT[1] = {other} / {rest}")


@rule("spindle")
def spindle_scaled_wrongly(draw: Draw) -> Tree:
    at = draw.line("set", "$ANOUT[1]")
    return draw.tree.put(
        at, draw.tree.at(at).text.replace("24000.0", draw.rng.choice(["12000.0", "2400.0", "24001.5E1", "23000.0"]))
    )


@rule("spindle")
def spindle_the_other_way(draw: Draw) -> Tree:
    """A negative speed."""
    at = draw.line("set", "$ANOUT[1]")
    return draw.tree.put(at, draw.tree.at(at).text.replace("= ", "= -", 1))


@rule("spindle", "wrong")
def spindle_on_another_channel(draw: Draw) -> Tree:
    at = draw.line("set", "$ANOUT[1]")
    return draw.tree.put(at, draw.tree.at(at).text.replace("[1]", "[2]", 1))


@rule("spindle", "wrong")
def spindle_on_another_output(draw: Draw) -> Tree:
    return draw.tree.put(_on(draw), f"$OUT[{draw.rng.choice([3, 11, 5])}] = TRUE")


@rule("spindle")
def another_speed_in_the_cut(draw: Draw) -> Tree:
    line = draw.rng.choice(["$ANOUT[1] = 3000 / 24000.0", "$ANOUT[1] = 0.9", "$ANOUT[1] = 0"])
    return draw.tree.before(draw.cut().at, line)


@rule("spindle")
def spindle_off_in_the_cut(draw: Draw) -> Tree:
    return draw.tree.before(draw.cut().at, "$OUT[1] = FALSE")


@rule("spindle")
def spindle_off_early(draw: Draw) -> Tree:
    off = _off(draw)
    cuts = [m for m in draw.motions if m.cut and draw.place(m.at) < draw.place(off)]
    m = draw.pick(cuts[-2:])
    return draw.tree.edit({off: [], m.at: [draw.tree.at(off), m.node]})


@rule("spindle")
def spindle_started_twice_at_two_speeds(draw: Draw) -> Tree:
    on = _on(draw)
    speed = _hook(draw, on)[0]
    half = draw.tree.at(speed).text.replace("24000.0", "48000.0")
    return draw.tree.after(on, half, draw.tree.at(on))


@rule("spindle", "open", only=("arcs", "holes", "turning", "tools"))
def spindle_stops_after_the_way_home(draw: Draw) -> Tree:
    """The program's own stop is lost, the footer's is left: later, but in the clear."""
    off = [a for a in draw.lines("set", "$OUT[1]", "FALSE") if ";" not in draw.tree.at(a).text][-1]
    return draw.tree.edit({off: [], draw.order[draw.place(off) + 1]: []})


@rule("spindle")
def nothing_stops_the_spindle(draw: Draw) -> Tree:
    return draw.tree.edit({a: [] for a in draw.lines("set", "$OUT[1]", "FALSE")})


@rule("spindle", only=("tilted",))
def the_footers_stop_dropped(draw: Draw) -> Tree:
    """Of a file that leaves the spindle on."""
    return draw.tree.put(draw.lines("set", "$OUT[1]", "FALSE")[-1])


@rule("spindle")
def spindle_started_again_at_the_end(draw: Draw) -> Tree:
    return draw.tree.before(draw.lines("end")[-1], "$OUT[1] = TRUE")


@rule("spindle", "wrong")
def spindle_by_pulse(draw: Draw) -> Tree:
    """The output is on for two seconds, not for the cut."""
    return draw.tree.put(_on(draw), f"PULSE ($OUT[1],TRUE,{draw.rng.choice(['0.5', '2.0'])})")


@rule("spindle", "wrong")
def a_pulse_in_the_cut(draw: Draw) -> Tree:
    return draw.tree.before(draw.cut().at, "PULSE ($OUT[1],FALSE,0.5)")


@rule("spindle", "wrong")
def the_output_ahead_of_its_motion(draw: Draw) -> Tree:
    """CONTINUE lets the advance run switch while the tool is still some motions back."""
    offs = [
        a for a in draw.order if draw.tree.at(a).name in ("$OUT[1]", "$OUT[2]") and draw.tree.at(a).value == "FALSE"
    ]
    return draw.tree.before(draw.pick([a for a in offs if ";" not in draw.tree.at(a).text]), "CONTINUE")


@rule("spindle", "wrong")
def an_output_by_number_from_a_variable(draw: Draw) -> Tree:
    cut = draw.cut()
    return draw.tree.before(cut.at, "I = 1", "$OUT[I] = FALSE")


@rule("spindle", "wrong")
def an_analogue_ramp(draw: Draw) -> Tree:
    """ANOUT ON: the speed follows something else from here on."""
    return draw.tree.before(draw.cut().at, "ANOUT ON $ANOUT[1] = 0.05*$VEL_ACT+0.1 DELAY=-0.01")


@rule("coolant", only=("arcs", "tools", "holes", "split"))
def coolant_on_dropped(draw: Draw) -> Tree:
    return draw.tree.put(draw.line("set", "$OUT[2]", "TRUE"))


@rule("coolant", only=("arcs", "tools", "holes", "split"))
def coolant_on_late(draw: Draw) -> Tree:
    at = draw.line("set", "$OUT[2]", "TRUE")
    return _moved(draw, [at], draw.next_motion(at, draw.rng.choice([3, 4])).at)


@rule("coolant", only=("arcs", "tools", "holes", "split"))
def coolant_off_early(draw: Draw) -> Tree:
    off = draw.lines("set", "$OUT[2]", "FALSE")[0]
    m = draw.pick([m for m in draw.motions if draw.place(m.at) < draw.place(off) and not m.own][-3:])
    return draw.tree.edit({off: [], m.at: [draw.tree.at(off), m.node]})


@rule("coolant", only=("arcs", "holes"))
def coolant_off_late(draw: Draw) -> Tree:
    off = draw.lines("set", "$OUT[2]", "FALSE")[0]
    return _moved(draw, [off], draw.next_motion(off, 2).at)


@rule("coolant", only=("arcs", "tools", "holes", "split"))
def coolant_never_off(draw: Draw) -> Tree:
    return draw.tree.edit({a: [] for a in draw.lines("set", "$OUT[2]", "FALSE")})


@rule("coolant")
def coolant_that_nobody_asked_for(draw: Draw) -> Tree:
    at = draw.cut().at
    return draw.tree.before(at, f"$OUT[2] = {draw.rng.choice(['TRUE', 'FALSE'])}")


@rule("coolant", only=("arcs", "tools", "holes", "split"))
def coolant_the_wrong_way_round(draw: Draw) -> Tree:
    at = draw.line("set", "$OUT[2]", "TRUE")
    return draw.tree.put(at, "$OUT[2] = FALSE")


@rule("events", "wrong")
def an_output_that_the_cell_does_not_name(draw: Draw) -> Tree:
    line = draw.rng.choice(["$OUT[7] = TRUE", "$OUT[16] = FALSE", "$ANOUT[3] = 0.4"])
    return draw.tree.before(draw.cut().at, line)


@rule("events", only=("arcs", "tools", "holes"))
def dwell_dropped(draw: Draw) -> Tree:
    return draw.tree.put(draw.pick(_dwells(draw)))


@rule("events", only=("arcs", "tools", "holes"), times=2)
def dwell_of_another_time(draw: Draw) -> Tree:
    at = draw.pick(_dwells(draw))
    seconds = float(draw.tree.at(at).value)
    return draw.tree.put(at, f"WAIT SEC {draw.rng.choice([0.0, 0.05, seconds * 10, seconds - 0.1, -seconds]):.3f}")


@rule("events", only=("arcs", "tools", "holes"))
def dwell_elsewhere(draw: Draw) -> Tree:
    at = draw.pick(_dwells(draw))
    if draw.rng.random() < 0.5:
        return _moved(draw, [at], draw.next_motion(at, 1).at)
    m = draw.last_motion(at)
    return draw.tree.edit({at: [], m.at: [draw.tree.at(at), m.node]})


@rule("events", only=("arcs", "tools", "holes"))
def dwell_twice(draw: Draw) -> Tree:
    at = draw.pick(_dwells(draw))
    return draw.tree.put(at, draw.tree.at(at), draw.tree.at(at))


@rule("events")
def a_dwell_that_nobody_asked_for(draw: Draw) -> Tree:
    m = draw.motion(lambda m: m.cut)
    return draw.tree.after(m.at, f"WAIT SEC {draw.rng.choice(['0.5', '5', '60.0'])}")


@rule("events", "wrong")
def a_wait_for_an_input(draw: Draw) -> Tree:
    line = draw.rng.choice(
        ["WAIT FOR $IN[4]", "WAIT FOR $IN[1] == FALSE", "WAIT FOR ( $IN[2] AND $IN[3] )", "WAIT FOR FALSE"]
    )
    return draw.tree.before(draw.cut().at, line)


@rule("events", only=("arcs", "tools", "holes", "tilted", "turning"))
def halt_dropped(draw: Draw) -> Tree:
    return draw.tree.put(draw.line("halt"))


@rule("events")
def a_halt_in_the_cut(draw: Draw) -> Tree:
    return draw.tree.before(draw.cut().at, "HALT")


@rule("events", only=("arcs", "tools", "holes", "split"))
def halt_elsewhere(draw: Draw) -> Tree:
    at = draw.line("halt")
    return _moved(draw, [at], draw.next_motion(at, draw.rng.choice([1, 2, 3])).at)


@rule("events", "wrong", only=("arcs", "holes", "tilted"))
def the_change_behind_the_start(draw: Draw) -> Tree:
    """HALT for the tool with the spindle turning."""
    at = draw.lines("halt")[0]
    on = draw.lines("set", "$OUT[1]", "TRUE")[0]
    return _moved(draw, [at], _hook(draw, on)[2])


@rule("events", only=("tools",))
def change_at_depth(draw: Draw) -> Tree:
    """The change ordered at the end of the first tool's cut."""
    halt = draw.lines("halt")[1]
    cuts = [m for m in draw.motions if m.cut and draw.place(m.at) < draw.place(halt)]
    return _moved(draw, [halt], cuts[-1].at)


@rule("events", only=("tools",))
def change_with_the_spindle_on(draw: Draw) -> Tree:
    halt = draw.lines("halt")[1]
    off = [a for a in draw.lines("set", "$OUT[1]", "FALSE") if draw.place(a) < draw.place(halt)][-1]
    return draw.tree.edit({off: [], draw.order[draw.place(off) + 1]: []})


@rule("events", only=("tools",))
def change_without_the_way_to_it(draw: Draw) -> Tree:
    """HALT above the part instead of at the change pose."""
    halt = draw.lines("halt")[1]
    return draw.tree.put(draw.last_motion(halt).at)


@rule("events", "open", only=("tools",))
def change_before_the_way_to_it(draw: Draw) -> Tree:
    """HALT 100 mm above the part instead of at the change pose: in the clear, the spindle off."""
    halt = draw.lines("halt")[1]
    m = draw.last_motion(halt)
    return draw.tree.edit({halt: [], m.at: [draw.tree.at(halt), m.node]})


@rule("events", only=("tools",))
def second_tool_without_its_start(draw: Draw) -> Tree:
    return draw.tree.edit({a: [] for a in _hook(draw, draw.lines("set", "$OUT[1]", "TRUE")[1])})


@rule("events", "open", only=("tools",))
def changes_of_tools_exchanged(draw: Draw) -> Tree:
    """`change to tool 2` first: what the operator reads."""
    a, b = draw.lines("halt")
    return draw.tree.edit({a: [draw.tree.at(b)], b: [draw.tree.at(a)]})


@rule("events", "open", only=("tools", "arcs"))
def change_to_another_number(draw: Draw) -> Tree:
    """Only a comment, though the one that the operator reads."""
    at = draw.lines("halt")[-1 if draw.name == "tools" else 0]
    return draw.tree.put(at, "HALT ;change to tool 9")


@rule("events")
def the_program_goes_on_after_home(draw: Draw) -> Tree:
    """Into the part once more behind the last HOME, with the spindle off."""
    first = draw.pick([m for m in draw.motions if m.cut and m.node.kind == "lin"])
    entry = draw.motion(lambda m: m.node.kind == "ptp" and not m.node.axes)
    return draw.tree.before(draw.lines("end")[-1], entry.node, "$VEL.CP = 0.100000", first.node, entry.node)
