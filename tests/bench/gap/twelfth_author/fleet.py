"""Machines as sheets are remembered (lengths of the size of the model named, no more), and the files that tell them."""

from __future__ import annotations

from .chains import Chain, Joint

WRIST_RANGE = ((-150, 150), (-105, 105), (-170, 170))


def elbow(
    name, d1, a1, a2, a3, d4, d6, *, masses, tool, payload, speed=90.0, signs=(1,) * 6, offsets=(0,) * 6, above=0.15
):
    """The six-axis arm of most makers: upright upper arm and level forearm at zero."""
    rows = [(-90, a1, 0, d1), (0, a2, -90, 0), (-90, a3, 0, 0), (90, 0, 0, d4), (-90, 0, 0, 0), (0, 0, 0, d6)]
    ranges = ((-110, 110), (-35, 60), (-50, 60), *WRIST_RANGE)
    joints = []
    for i, (row, (low, high)) in enumerate(zip(rows, ranges, strict=True)):
        low, high = sorted((signs[i] * low + offsets[i], signs[i] * high + offsets[i]))
        joints.append(Joint(f"A{i + 1}", row, sign=signs[i], offset=offsets[i], low=low, high=high, speed=speed))
    m1, m2, m3, m4 = masses
    bodies = (
        ("A1", m1, (-0.5 * a1, 0.25 * d1, 0.0)),
        ("A2", m2, (-0.55 * a2, 0.0, 0.12 * a2)),
        ("A3", m3, (-0.3 * a3, 0.0, 0.2 * d4)),
        ("A4", m4, (0.0, 0.35 * d4, 0.0)),
    )
    home = tuple(signs[i] * v + offsets[i] for i, v in enumerate((0, 10, 10, 0, 60, 0)))
    return Chain(name, tuple(joints), tool=tool, masses=bodies, payload=payload, home=home, above=above)


def rod(
    name,
    rows,
    kinds,
    ranges,
    *,
    convention="standard",
    tool=(0, 0, 100, 0, 180, 0),
    masses=(),
    payload=0.0,
    home=None,
    above=None,
    speed=60.0,
):
    """Any other chain: rows, kinds of its joints, ranges in degrees or mm."""
    joints = tuple(
        Joint(f"A{i + 1}", row, kind=k, low=lo, high=hi, speed=speed if k == "R" else 4 * speed)
        for i, (row, k, (lo, hi)) in enumerate(zip(rows, kinds, ranges, strict=True))
    )
    home = home or tuple((j.low + j.high) / 2 for j in joints)
    return Chain(name, joints, convention=convention, tool=tool, masses=masses, payload=payload, home=home, above=above)


def _carried(arm, name, joint, base, home):
    """An arm on a rail or lift (`joint`, a carriage), or before a positioner (a workpiece)."""
    return Chain(
        name,
        (joint, *arm.joints),
        arm.convention,
        base,
        arm.tool,
        arm.masses,
        arm.payload,
        (home, *arm.home),
        arm.above,
    )


def _fleet():
    small = (4.0, 8.0, 6.0, 3.0)
    middle = (55.0, 60.0, 45.0, 22.0)
    large = (320.0, 260.0, 190.0, 90.0)
    torch = (20, 0, 320, 0, 135, 0)
    probe = (0, 0, 180, 0, 180, 0)
    hand = (0, 60, 240, 0, 180, 0)
    gun = (320, 0, 260, 0, 90, 0)
    m20 = elbow("m20_handler", 525, 150, 790, 250, 835, 100, masses=middle, tool=hand, payload=14)
    ur = rod(
        "ur5e_cell",
        [(90, 0, 0, 162.5), (0, -425, 0, 0), (0, -392.2, 0, 0), (90, 0, 0, 133.3), (-90, 0, 0, 99.7), (0, 0, 0, 99.6)],
        "RRRRRR",
        [(-150, 150), (-140, -40), (20, 120), (-150, -30), (-130, -40), (-150, 150)],
        masses=(
            ("A1", 3.7, (0, -30, 0)),
            ("A2", 8.4, (210, 0, 110)),
            ("A3", 2.3, (150, 0, 20)),
            ("A4", 1.2, (0, -18, 16)),
        ),
        payload=2.5,
        home=(0, -90, 90, -90, -90, 0),
        above=0.1,
    )
    gp25 = elbow(
        "gp25_cell", 505, 150, 760, 200, 795, 100, masses=middle, tool=probe, payload=12, signs=(1, 1, -1, -1, -1, -1)
    )
    rs20 = elbow(
        "rs020_cell", 430, 150, 770, 110, 780, 90, masses=middle, tool=gun, payload=15, signs=(-1, 1, -1, 1, 1, 1)
    )
    irb = elbow("irb4600_cell", 495, 175, 900, 175, 960, 135, masses=(90, 110, 70, 30), tool=probe, payload=30)
    nj = elbow(
        "nj220_cell",
        830,
        400,
        1175,
        250,
        1445,
        230,
        masses=large,
        tool=gun,
        payload=140,
        offsets=(0, -90, 90, 0, 0, 0),
        above=0.3,
    )
    vs = elbow("vs087_cell", 395, 30, 430, 20, 430, 80, masses=small, tool=(0, 0, 120, 0, 180, 0), payload=3, above=0.1)
    tx = elbow("tx290_cell", 478, 50, 425, 0, 425, 100, masses=(12, 22, 15, 6), tool=probe, payload=6, above=0.1)
    mz = elbow("mz07_cell", 345, 50, 330, 45, 340, 73, masses=small, tool=torch, payload=3, above=0.1)
    kr = elbow(
        "kr210_bare",
        675,
        350,
        1150,
        41,
        1200,
        215,
        masses=large,
        tool=(0, 0, 420, 0, 180, 0),
        payload=110,
        above=0.3,
        offsets=(0, -90, 90, 0, 0, 0),
    )
    panda = rod(
        "panda_bench",
        [
            (0, 0, 0, 333),
            (-90, 0, 0, 0),
            (90, 0, 0, 316),
            (90, 82.5, 0, 0),
            (-90, -82.5, 0, 384),
            (90, 0, 0, 0),
            (90, 88, 0, 107),
        ],
        "RRRRRRR",
        [(-120, 120), (-50, 70), (-100, 100), (-140, -40), (-110, 110), (40, 180), (-120, 120)],
        convention="modified",
        masses=(
            ("A1", 4.0, (0, 0, -60)),
            ("A2", 4.0, (0, -70, 0)),
            ("A3", 3.0, (40, 0, -60)),
            ("A4", 3.0, (-40, 60, 0)),
            ("A5", 3.2, (0, 30, -110)),
            ("A6", 1.6, (60, 0, 0)),
        ),
        payload=1.5,
        home=(0, 10, 0, -90, 0, 100, 40),
        above=0.1,
    )
    scara = rod(
        "g10_scara",
        [(0, 400, 0, 280), (180, 250, 0, 0), (0, 0, 0, 60), (0, 0, 0, 0)],
        "RRPR",
        [(-110, 110), (-130, 130), (0, 170), (-170, 170)],
        tool=(0, 0, 90, 0, 180, 0),
        home=(0, 60, 60, 0),
        speed=100,
    )
    column = rod("z_column", [(0, 0, 0, 0)], "P", [(0, 1400)], tool=(0, 0, 0, 0, 180, 0), home=(700,))
    index = rod("index_table", [(0, 0, 0, 200)], "R", [(-178, 178)], tool=(260, 0, 40, 0, 180, 0), home=(0,), speed=30)
    cross = rod("cross_slide", [(-90, 0, 0, 0), (0, 0, 0, 0)], "PP", [(0, 900), (0, 500)], tool=(0, 0, 80, 0, 180, 0))
    rail = Joint("E1", (90, 0, 0, 0), kind="P", role="carriage", low=0, high=6000, speed=600)
    lift = Joint("E1", (0, 0, 0, 0), kind="P", role="carriage", low=0, high=900, speed=150)
    table = Joint("E2", (0, -1100, 0, -150), role="workpiece", sign=-1, low=-170, high=170, speed=40)
    return (
        m20,
        ur,
        gp25,
        rs20,
        irb,
        nj,
        vs,
        tx,
        mz,
        kr,
        panda,
        scara,
        column,
        index,
        cross,
        _carried(kr, "kr210_on_rail", rail, (0, 0, 250, 0, 0, -90), 2500),
        _carried(ur, "ur5e_on_lift", lift, (0, 0, 600, 0, 0, 0), 400),
        _carried(mz, "mz07_positioner", table, (0, 0, 0, 0, 0, 0), 0),
    )


FLEET = {chain.name: chain for chain in _fleet()}


def _numbers(values):
    return "[" + ", ".join(f"{v:.10g}" for v in values) + "]"


def cell_text(chain):
    """cell.toml of a cell that is only measured."""
    lines = ["schema = 1", f'name = "{chain.name}"', 'standing = "datasheet"', ""]
    lines += ["[kinematics]", f"base_follows_table = {str(any(j.role == 'workpiece' for j in chain.joints)).lower()}"]
    lines += [
        "characteristic_length_mm = 300",
        f"base_to_first = {_numbers(chain.base)}",
        "foot_to_root = [0, 0, 0, 0, 0, 0]",
    ]
    lines += ["wrist_to_flange = [0, 0, 0, 0, 0, 0]", ""]
    for j in chain.joints:
        if j.role == "arm":
            continue
        alpha, a, theta, d = j.dh
        kind = "prismatic" if j.kind == "P" else "revolute"
        lines += ["[[joint]]", f'name = "{j.name}"', f'role = "{j.role}"', f'type = "{kind}"']
        lines += [f"dh = {{ alpha_deg = {alpha}, a_mm = {a}, theta_deg = {theta}, d_mm = {d} }}"]
        lines += [f"axis = {{ sign = {j.sign}, offset_{'mm' if j.kind == 'P' else 'deg'} = {j.offset} }}", ""]
    arm = [j for j in chain.joints if j.role == "arm"]
    lines += ["[arm]", f'convention = "{chain.convention}"', "dh = ["]
    lines += [f"  {_numbers(j.dh)}," for j in arm] + ["]"]
    if any(j.kind == "P" for j in arm):
        lines += [f'kinds = "{"".join(j.kind for j in arm)}"']
    if any(j.sign != 1 for j in arm):
        lines += [f"signs = {[j.sign for j in arm]}"]
    if any(j.offset for j in arm):
        lines += [f"offsets_deg = {_numbers([j.offset for j in arm])}"]
    lines += ["", "[tool]", f"flange_to_tool = {_numbers(chain.tool)}", ""]
    if chain.payload:
        lines += ["[load]", f"payload_kg = {chain.payload:g}", ""]
    for name, kg, c in chain.masses:
        lines += [
            "[[mass]]",
            f'name = "of_{name}"',
            f'after = "{name}"',
            f"mass_kg = {kg:g}",
            f"center_mm = {_numbers(c)}",
            "",
        ]
    return "\n".join(lines)
