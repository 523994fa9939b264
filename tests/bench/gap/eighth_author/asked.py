"""Ten cases for a person who has seen neither the code nor the labels: the diagnosis' page and what they are asked;
apart from it, the sheet to score by."""

from __future__ import annotations

import shutil
import tomllib

import numpy as np

SHARES = {"none": 1, "outside": 2, "one": 3, "two": 2, "three": 2}
QUESTIONS = (
    "What would you do at the machine, and in what order? At most three things; 'nothing' is an answer.",
    "Which axis, part or instrument would you look at first?",
    "Is there anything that the page names and that you would leave alone for now? Why?",
    "Would you run or measure something before you touch anything? What?",
    "How sure are you that the first thing helps, from 0 to 100?",
)
DEEDS = {
    "frame_base": "the foot: level it, or measure where it stands and correct the base",
    "frame_tool": "measure the tool's tip anew, or seat the tool anew",
    "frame_table": "set the tailstock in line, or measure the mandrel's axis anew",
    "turntable": "the mandrel's chuck, bearing and index gear",
    "joint_offset": "master {axes} anew",
    "geometry": "calibrate the arm's rows; no single part is at fault",
    "joint_compliance": "nothing to adjust; correct it in the program, or look at the gears of {axes} if softer than their like",
    "payload": "weigh the head and what hangs on the forearm, and tell the controller",
    "lean": "the anchors of the foot",
    "backlash": "take up the play of {axes}",
    "hysteresis": "preload, gear and bearing of {axes}",
    "gear_ripple": "the gear of {axes}, or a table of corrections for it",
    "motor_commutation": "current sensors and commutation of the drive of {axes}",
    "servo_lag": "tune the position loops: gain, speed fed forward",
    "setpoint_delay": "the bus to {axes}: its cycle",
    "acceleration_error": "work with less acceleration, or have the gears of {axes} looked at",
    "friction": "grease and drive of {axes}: reset time, friction compensation",
    "wrist_coupling": "the coupling that the controller reckons with for {axes}",
    "thermal_drift": "warm the machine up before it works, or measure it warm",
    "track": "the column's guide and screw: plumb, straighten, or correct by a table",
    "measurement_scale": "the instrument's air temperature and pressure; nothing at the machine",
    "measurement_drift": "the instrument's stand; nothing at the machine",
    "latency": "the instrument's timing; nothing at the machine",
    "cutting_force": "a lighter cut, or correct for the force; nothing is broken",
    "early_reading": "wait longer before each reading; nothing at the machine",
    "slosh": "what swings on the forearm: the tank",
    "racking": "the bridge's second drive: it follows the first late",
    "floating": "the floating spindle: its air, or lock it",
    "lift_clamp": "the lift's clamp: it tips the boom as it shuts",
    "spindle_growth": "the spindle: let it warm, or measure its length as it turns",
    "graduated_circle": "have the tracker's angles checked; nothing at the machine",
    "tow": "the pull of the tows at the creel",
    "foldback": "the amplifier of {axes}: its cooling and current limit",
}


def chosen(plan, seed):
    """{letter: number} of ten cases: of each kind the first ones by number, the logs among the ones in turn, in an
    order that says nothing."""
    picked = []
    for kind, count in SHARES.items():
        mine = [i for i, p in enumerate(plan) if p["kind"] == kind]
        if kind == "one":
            firsts = [next((i for i in mine if plan[i]["log"] == log), None) for log in ("path", "poses", "drives")]
            mine = [i for i in firsts if i is not None] + [i for i in mine if i not in firsts]
        picked += mine[:count]
    order = np.random.default_rng([seed, 10]).permutation(sorted(picked))
    return dict(zip("ABCDEFGHIJ", order.tolist(), strict=True))


def hand_out(out, cases):
    """`DIR/asked`: of each case its page and a sheet of questions, nothing from the labels. Where a page is missing the
    case was not answered."""
    folder = out / "asked"
    folder.mkdir(parents=True, exist_ok=True)
    for letter, number in cases.items():
        page = out / "answers" / f"{number:02d}" / "diagnosis" / "diagnosis.html"
        if not page.exists():
            raise SystemExit(f"{page}: no such page; let the case be answered first (--step answer --only {number})")
        shutil.copyfile(page, folder / f"{letter}.html")
        (folder / f"{letter}.md").write_text(_sheet(letter, out / "cases" / f"{number:02d}"), encoding="utf-8")
    print(f"{len(cases)} pages and sheets in {folder}")


def _sheet(letter, case):
    title = tomllib.loads((case / "cell" / "cell.toml").read_text(encoding="utf-8"))["title"]
    lines = [f"# {letter}: {title}", "", "What was logged:", ""]
    for log in sorted(case.glob("*.csv")):
        head, *rows = log.read_text(encoding="utf-8").splitlines()
        told = tomllib.loads(log.with_suffix(".toml").read_text(encoding="utf-8"))
        sort = "poses at rest" if told.get("poses") else ("a path with a tracker" if ",x," in head else "drives alone")
        lines.append(f"- {log.stem}: {sort}, {len(rows)} rows")
    lines += ["", f"Read {letter}.html as long as you like. You can't ask anybody. Then write:", ""]
    for k, question in enumerate(QUESTIONS, 1):
        lines += [f"{k}. {question}", "", "   ......", ""]
    return "\n".join([*lines, "Minutes that it took: ......", ""])


def scoring(cases, labels):
    """The sheet to score by, from labels: not for the person who is asked."""
    lines = [
        "# What was wrong, and what is right to do",
        "",
        "Not for the person who is asked. Of each cause: 2 points for the right deed at the right place (or for that of a",
        "name that the logs can't tell from it), 1 for the right place or a run that would tell, 0 for neither. One point off",
        "for every thing that is changed and was in order (measuring, looking and waiting change nothing). Where nothing is",
        "wrong: 2 for nothing.",
        "",
    ]
    for letter, number in cases.items():
        label = labels[number]
        lines += [f"## {letter} (case {number})", ""]
        gap, noise, left = label["perfect"]["rms_before_mm"], label["noise_mm"], label["left_mm"]
        lines.append(f"Gap {gap:.3g} mm rms, noise {noise:.3g} mm, what nobody can name {left:.3g} mm.")
        lines += ["", *(_scored(n, e) for n, e in label["effects"].items())]
        if not label["effects"]:
            lines.append("- Nothing is wrong: 2 points for doing nothing. Points: ..")
        lines += ["- Things changed that were in order: .. (one point off each)", ""]
    return "\n".join(lines)


def _scored(name, effect):
    where = " and ".join(effect["axes"])
    like = f" Right as well, by what these logs show: {', '.join(effect['alike'])}." if effect["alike"] else ""
    place = f"{name}, {where}" if where else name
    return f"- {place}, {effect['rms_mm']:.3g} mm: {DEEDS[name].format(axes=where)}.{like} Points: .. of 2"
