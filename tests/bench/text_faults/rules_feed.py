"""Feeds: `$VEL.CP` raised, lowered, dropped, late, in another unit, and what else sets a speed."""

from __future__ import annotations

from text_faults.context import Draw, NothingToDrawError
from text_faults.rules import rule
from text_faults.tree import At, Tree


def _speeds(draw: Draw, *, cut: bool | None = None) -> list[At]:
    """Lines that set the feed, those of cuts or of rapids; not the last where nothing follows."""
    lines = draw.lines("set", "$VEL.CP")
    return [a for a in lines if cut is None or (float(draw.tree.at(a).value) < 0.1) == cut]


def _set(draw: Draw, at: At, value: float) -> Tree:
    return draw.tree.put(at, f"$VEL.CP = {value:.6f}")


@rule("feed")
def raised_by_little(draw: Draw) -> Tree:
    at = draw.pick(_speeds(draw, cut=True))
    return _set(draw, at, float(draw.tree.at(at).value) * draw.rng.uniform(1.02, 1.3))


@rule("feed")
def raised_by_much(draw: Draw) -> Tree:
    at = draw.pick(_speeds(draw, cut=True))
    return _set(draw, at, float(draw.tree.at(at).value) * draw.rng.uniform(2.0, 8.0))


@rule("feed")
def lowered_for_no_reason(draw: Draw) -> Tree:
    at = draw.pick(_speeds(draw, cut=True))
    return _set(draw, at, float(draw.tree.at(at).value) * draw.rng.uniform(0.2, 0.9))


@rule("feed")
def a_thousand_times(draw: Draw) -> Tree:
    """mm/s for m/s."""
    at = draw.pick(_speeds(draw, cut=True))
    return _set(draw, at, float(draw.tree.at(at).value) * 1000.0)


@rule("feed")
def sixty_times(draw: Draw) -> Tree:
    """Metres a minute for metres a second, or the other way."""
    at = draw.pick(_speeds(draw, cut=True))
    return _set(draw, at, float(draw.tree.at(at).value) * draw.rng.choice([60.0, 1.0 / 60.0]))


@rule("feed", times=2)
def a_speed_dropped(draw: Draw) -> Tree:
    return draw.tree.put(draw.pick(_speeds(draw)))


@rule("feed", times=2)
def a_speed_one_motion_later(draw: Draw) -> Tree:
    at = draw.pick(_speeds(draw))
    m = draw.next_motion(at)
    if m.at.file != at.file:
        raise NothingToDrawError
    return draw.tree.edit({at: [], m.at: [m.node, draw.tree.at(at)]})


@rule("feed", times=2)
def a_speed_one_motion_earlier(draw: Draw) -> Tree:
    at = draw.pick(_speeds(draw))
    m = draw.last_motion(at)
    if m.at.file != at.file:
        raise NothingToDrawError
    return draw.tree.edit({at: [], m.at: [draw.tree.at(at), m.node]})


@rule("feed")
def two_speeds_swapped(draw: Draw) -> Tree:
    a, b = draw.pick(_speeds(draw, cut=True)), draw.pick(_speeds(draw))
    if draw.tree.at(a).value == draw.tree.at(b).value:
        raise NothingToDrawError
    return draw.tree.edit({a: [draw.tree.at(b)], b: [draw.tree.at(a)]})


@rule("feed")
def an_extra_speed_in_the_cut(draw: Draw) -> Tree:
    m = draw.cut()
    return draw.tree.before(m.at, f"$VEL.CP = {m.speed * draw.rng.choice([0.25, 1.5, 4.0]):.6f}")


@rule("feed")
def every_feed_by_a_tenth(draw: Draw) -> Tree:
    change = draw.rng.choice([0.9, 1.1])
    return draw.tree.edit(
        {a: [f"$VEL.CP = {float(draw.tree.at(a).value) * change:.6f}"] for a in _speeds(draw, cut=True)}
    )


@rule("feed", "open")
def rapid_ten_times_as_fast(draw: Draw) -> Tree:
    """The file's RAPID names no speed; the set-up's is a default."""
    at = draw.pick(_speeds(draw, cut=False))
    return _set(draw, at, 1.0)


@rule("feed", "wrong")
def no_speed_or_a_negative_one(draw: Draw) -> Tree:
    at = draw.pick(_speeds(draw, cut=True))
    return draw.tree.put(at, f"$VEL.CP = {draw.rng.choice(['0.0', '-0.0050', '', 'NAN'])}")


@rule("feed", "wrong")
def speed_by_another_variable(draw: Draw) -> Tree:
    """The cut's own line lost, a look-alike left."""
    at = draw.pick(_speeds(draw, cut=True))
    name = draw.rng.choice(["$VEL.C", "$VEL_CP", "$VELCP", "VEL.CP", "$VEL_ACT", "$VEL_MA.CP"])
    return draw.tree.put(at, f"{name} = {draw.tree.at(at).value}")


@rule("feed", "wrong")
def default_speeds_in_the_cut(draw: Draw) -> Tree:
    """BAS sets the controller's default speed."""
    call = draw.rng.choice(["BAS (#INITMOV,0 )", "BAS (#VEL_CP,0.5 )", "BAS (#CP_DEFAULT,0 )", "BAS (#CP_PARAMS,0.3 )"])
    return draw.tree.before(draw.cut().at, call)


@rule("feed", "wrong")
def override(draw: Draw) -> Tree:
    return draw.tree.before(draw.cut().at, f"$OV_PRO = {draw.rng.choice([10, 50])}")


@rule("feed", "wrong", only=("tilted", "turning"))
def turning_speed_that_brakes_the_cut(draw: Draw) -> Tree:
    """Half a degree a second where the tool has to turn by some degrees within a second."""
    names = ("$VEL.ORI1", "$VEL.ORI2", "$ACC.ORI1")
    name = draw.rng.choice(names[:2])
    return draw.tree.put(draw.line("set", name), f"{name} = 0.500")


@rule("feed", "open")
def another_acceleration(draw: Draw) -> Tree:
    return draw.tree.put(draw.line("set", "$ACC.CP"), f"$ACC.CP = {draw.rng.choice(['0.2000', '8.0000'])}")


@rule("feed", "open")
def ptp_at_full_speed(draw: Draw) -> Tree:
    """The ways through the air at 100 %."""
    return draw.tree.put(draw.lines("bas")[-1], "BAS (#VEL_PTP,100 )")
