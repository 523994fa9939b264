"""Fourteen machines (lengths as remembered, none a maker's sheet) and the cell.toml that tells each."""

from __future__ import annotations

from dataclasses import replace

from .arms import Axis, Machine

# of six axes in q: turned to either side, upper arm, forearm, wrist
SPAN = ((-100, 100), (-40, 45), (-45, 50), (-140, 140), (-100, 100), (-160, 160))


def upright(
    name, h, a1, l2, a3, l4, l6, *, kg, tool, load, zeros=(0,) * 6, signs=(1,) * 6, floor=0.2, top=80.0, **more
):
    """Shoulder, elbow and a wrist in line, the upper arm upright and the forearm level at q = 0."""
    rows = ((-90, a1, 0, h), (0, l2, -90, 0), (-90, a3, 0, 0), (90, 0, 0, l4), (-90, 0, 0, 0), (0, 0, 0, l6))
    axes = []
    for i, (row, (lo, hi)) in enumerate(zip(rows, SPAN, strict=True)):
        lo, hi = sorted((signs[i] * lo + zeros[i], signs[i] * hi + zeros[i]))
        axes.append(Axis(f"A{i + 1}", row, lo, hi, top * (1.6 if i > 2 else 1.0), sign=signs[i], zero=zeros[i]))
    home = tuple(s * q + z for s, q, z in zip(signs, (0, -5, 15, 0, 65, 0), zeros, strict=True))
    lumps = (
        ("A1", kg[0], (-0.6 * a1, 0.3 * h, 0)),
        ("A2", kg[1], (-0.5 * l2, 0, 0.1 * l2)),
        ("A3", kg[2], (-0.4 * a3, 0, 0.25 * l4)),
        ("A5", kg[3], (0, 0, 0.2 * l6)),
    )
    return Machine(name, tuple(axes), tool, home, lumps=lumps, load=load, floor=floor, **more)


def free(name, rows, spans, *, slides="", top=70.0, **more):
    """Any other: rows, ranges; which slide (a letter each, S or R)."""
    slides = slides or "R" * len(rows)
    axes = tuple(
        Axis(f"A{i + 1}", row, lo, hi, 300.0 if s == "S" else top, s == "S")
        for i, (row, (lo, hi), s) in enumerate(zip(rows, spans, slides, strict=True))
    )
    return Machine(name, axes, **more)


def behind(axis, arm, name, at, drop=0.0):
    """An arm behind a rail or a workpiece axis, both along x of the world; `drop` mm below that axis."""
    alpha, a, theta, d = arm.axes[0].row
    axes = (axis, replace(arm.axes[0], row=(alpha, a, theta, d - drop)), *arm.axes[1:])
    return replace(arm, name=name, axes=axes, home=(at, *arm.home), base=(0, 0, 0, 90, 0, 90))


def _arms():
    ball, torch, hand = (0, 0, 150, 0, 180, 0), (15, 0, 340, 0, 140, 0), (40, -30, 260, 0, 180, 0)
    kuka = {"zeros": (0, -90, 90, 0, 0, 0), "signs": (-1, 1, 1, -1, 1, -1)}
    kr16 = upright("kr16", 675, 260, 680, 35, 670, 115, kg=(60, 55, 40, 12), tool=hand, load=12, **kuka)
    r2000 = upright(
        "r2000",
        670,
        312,
        1075,
        225,
        1280,
        215,
        kg=(350, 260, 190, 60),
        tool=(0, 120, 380, 0, 180, 0),
        load=150,
        floor=0.35,
        top=55,
    )
    irb2400 = upright("irb2400", 615, 100, 705, 135, 755, 85, kg=(80, 60, 45, 14), tool=ball, load=8)
    kr10 = upright(
        "kr10_ceiling",
        400,
        25,
        560,
        35,
        515,
        80,
        kg=(9, 13, 9, 3),
        tool=ball,
        load=5,
        base=(0, 0, 2400, 0, 180, 0),
        **kuka,
    )
    ta = upright(
        "ta_arm",
        430,
        150,
        560,
        130,
        620,
        105,
        kg=(40, 35, 28, 8),
        tool=torch,
        load=5,
        floor=-0.3,
        signs=(1, 1, -1, 1, -1, 1),
    )
    kr120 = upright(
        "kr120_arm",
        645,
        330,
        1150,
        115,
        1220,
        215,
        kg=(300, 230, 180, 55),
        tool=(0, 0, 450, 0, 180, 0),
        load=100,
        floor=0.4,
        top=50,
        **kuka,
    )
    rail = Axis("E1", (-90, 250, 0, 0), 0, 4200, 500, True, "carriage")
    drum = Axis("E2", (-90, -1150, 0, 250), -160, 160, 35, False, "workpiece", -1)
    return (
        kr16,
        r2000,
        irb2400,
        kr10,
        behind(rail, kr120, "kr120_rail", 2100),
        behind(drum, ta, "ta_headstock", 0, 850),
    )


def _others():
    ur_rows = (
        (90, 0, 0, 180.7),
        (0, -612.7, 0, 0),
        (0, -571.55, 0, 0),
        (90, 0, 0, 174.15),
        (-90, 0, 0, 119.85),
        (0, 0, 0, 116.55),
    )
    ur = free(
        "ur10e",
        ur_rows,
        ((-150, 150), (-140, -45), (25, 120), (-150, -30), (-130, -45), (-150, 150)),
        tool=(0, 0, 130, 0, 180, 0),
        home=(0, -90, 90, -90, -90, 0),
        lumps=(("A1", 7.4, (0, -20, 0)), ("A2", 13, (300, 0, 160)), ("A3", 4, (270, 0, 50)), ("A5", 4, (0, 0, 0))),
        load=6,
        floor=0.15,
    )
    doosan = free(
        "m1013",
        ((-90, 0, 0, 152.5), (0, 620, -90, 34.5), (90, 0, 90, 0), (-90, 0, 0, 559), (90, 0, 0, 0), (0, 0, 0, 121)),
        ((-140, 140), (-45, 50), (45, 130), (-140, 140), (30, 115), (-150, 150)),
        tool=(25, 0, 170, 0, 180, 0),
        home=(0, 0, 90, 0, 70, 0),
        lumps=(("A1", 8, (0, 0, 0)), ("A2", 10, (-300, 0, 80)), ("A3", 5, (0, 0, 60)), ("A5", 4, (0, 0, 0))),
        load=5,
        floor=0.15,
    )
    iiwa = free(
        "iiwa14",
        (
            (-90, 0, 0, 360),
            (90, 0, 0, 0),
            (90, 0, 0, 420),
            (-90, 0, 0, 0),
            (-90, 0, 0, 400),
            (90, 0, 0, 0),
            (0, 0, 0, 126),
        ),
        ((-120, 120), (-20, 70), (-100, 100), (-105, -35), (-120, 120), (-85, 85), (-140, 140)),
        tool=(0, 30, 140, 0, 180, 0),
        home=(0, 30, 0, -80, 0, 60, 0),
        lumps=(("A2", 7, (0, -30, 60)), ("A4", 5, (0, 40, 40)), ("A6", 4, (0, 0, 20))),
        load=7,
        floor=0.15,
    )
    scara = free(
        "ts60",
        ((0, 325, 0, 310), (180, 275, 0, 0), (0, 0, 0, 40), (0, 0, 0, 0)),
        ((-120, 120), (-130, 130), (10, 190), (-170, 170)),
        slides="RRSR",
        top=110,
        tool=(0, 0, 60, 0, 180, 0),
        home=(10, 60, 80, 0),
    )
    portal = free(
        "portal",
        ((90, 0, 90, 0), (-90, 0, 90, 0), (0, 0, 0, 0), (0, 0, 0, 300)),
        ((0, 2600), (0, 1400), (0, 600), (-170, 170)),
        slides="SSSR",
        tool=(60, 0, 90, 0, 180, 0),
        home=(1300, 700, 300, 0),
        base=(0, 0, 0, 90, 0, 90),
    )
    trunnion = free(
        "trunnion",
        ((90, 0, 0, 0), (0, 0, 0, 120)),
        ((-95, 95), (-175, 175)),
        top=25,
        tool=(170, 0, 45, 0, 0, 0),
        home=(0, 0),
    )
    paint = free(
        "paint",
        ((-90, 250, 0, 850), (0, 1250, -90, 0), (-90, 90, 0, 0), (60, 0, 0, 1400), (-60, 0, 0, 110), (0, 0, 0, 140)),
        ((-80, 80), (-35, 40), (-45, 40), (-150, 150), (-150, 150), (-170, 170)),
        tool=(0, 0, 300, 0, 180, 0),
        home=(0, 0, 10, 20, 80, 0),
        lumps=(
            ("A1", 260, (-150, 250, 0)),
            ("A2", 150, (-600, 0, 100)),
            ("A3", 120, (-40, 0, 300)),
            ("A5", 25, (0, 0, 0)),
        ),
        load=12,
        floor=0.3,
    )
    meca = free(
        "meca500",
        ((-90, 0, 0, 135), (0, 135, -90, 0), (-90, 38, 0, 0), (90, 0, 0, 120), (-90, 0, 0, 0), (0, 0, 0, 70)),
        ((-120, 120), (-40, 60), (-60, 50), (-140, 140), (-100, 100), (-160, 160)),
        tool=(0, 0, 60, 0, 180, 0),
        home=(0, 0, 10, 0, 60, 0),
        lumps=(("A2", 1.1, (-60, 0, 20)), ("A3", 0.8, (0, 0, 30))),
        load=0.4,
        floor=0.05,
    )
    return ur, doosan, iiwa, scara, portal, trunnion, paint, meca


PARK = {m.name: m for m in (*_arms(), *_others())}


def _list(values):
    return "[" + ", ".join(f"{v:.10g}" for v in values) + "]"


def _joints(m):
    """Every axis by itself, as a cell with a rail or a workpiece axis is told."""
    out = []
    for a in m.axes:
        alpha, length, theta, d = a.row
        kind, word = ("prismatic", "mm") if a.slides else ("revolute", "deg")
        out += [f'[[joint]]\nname = "{a.name}"\nrole = "{a.role}"\ntype = "{kind}"']
        out += [f"dh = {{ alpha_deg = {alpha}, a_mm = {length}, theta_deg = {theta}, d_mm = {d} }}"]
        out += [f"axis = {{ sign = {a.sign}, offset_{word} = {a.zero} }}\n"]
    return out


def _arm(m):
    """An arm in short."""
    out = ["[arm]", f'convention = "{"modified" if m.craig else "standard"}"', "dh = ["]
    out += [f"  {_list(a.row)}," for a in m.axes] + ["]"]
    if any(a.slides for a in m.axes):
        out += ['kinds = "' + "".join("P" if a.slides else "R" for a in m.axes) + '"']
    if any(a.sign < 0 for a in m.axes):
        out += [f"signs = {[a.sign for a in m.axes]}"]
    if any(a.zero for a in m.axes):
        out += [f"offsets_deg = {_list([a.zero for a in m.axes])}"]
    return out


def cell_text(m):
    """cell.toml of a cell that is only measured."""
    turned = any(a.role == "workpiece" for a in m.axes)
    out = [f'schema = 1\nname = "{m.name}"\nstanding = "measured"\n\n[kinematics]']
    out += [
        f"base_follows_table = {str(turned).lower()}",
        "characteristic_length_mm = 400",
        f"base_to_first = {_list(m.base)}",
    ]
    out += ["foot_to_root = [0, 0, 0, 0, 0, 0]", "wrist_to_flange = [0, 0, 0, 0, 0, 0]\n"]
    if m.first:
        out += _joints(m)
    else:
        out += _arm(m)
    out += [f"\n[tool]\nflange_to_tool = {_list(m.tool)}\n"]
    if m.load:
        out += [f"[load]\npayload_kg = {m.load:g}\n"]
    for k, (name, kg, c) in enumerate(m.lumps):
        out += [f'[[mass]]\nname = "lump_{k}"\nafter = "{name}"\nmass_kg = {kg:g}\ncenter_mm = {_list(c)}\n']
    return "\n".join(out)
