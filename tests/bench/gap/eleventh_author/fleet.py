"""Fourteen machines of a few trades, and the files that tell them. Masses and stiffnesses are assumed, usual for the class."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .robots import Joint, Lump, Robot, frame, place

__all__ = ["FLEET"]

D = np.pi / 180


def _tool(tool) -> str:
    return f"\n[tool]\nflange_to_tool = [{', '.join(str(x) for x in tool)}]\n"


def _carriage(carriage, table, first) -> tuple[str, np.ndarray, list]:
    """Text, the frame of the arm's first joint, and joints of a table and a carriage before the arm."""
    text = f"\n[kinematics]\nbase_to_first = {list(first)}\nbase_follows_table = {'true' if table else 'false'}\n"
    T, joints = frame(first), []
    for name, role, slides, row, span, speed in [*table, *carriage]:
        alpha, a, theta, d = row
        kind, unit = ("prismatic", "mm") if slides else ("revolute", "deg")
        text += (
            f'\n[[joint]]\nname = "{name}"\nrole = "{role}"\ntype = "{kind}"\n'
            f"dh = {{ alpha_deg = {alpha}, a_mm = {a}, theta_deg = {theta}, d_mm = {d} }}\n"
            f"axis = {{ sign = 1, offset_{unit} = 0 }}\n"
        )
        low, high = (np.array(span) * (1 if slides else D)).tolist()
        joints.append(Joint(name, T, low, high, speed, slides, role=role, big=1.0 if slides else 900.0))
        T = place(0, 0, d, (0, 0, theta)) @ place(a, 0, 0, (alpha, 0, 0))
    return text, T, joints


def _by_rows(
    name,
    rows,
    spans,
    speeds,
    soft,
    masses,
    tool,
    ready,
    *,
    kinds="",
    modified=False,
    signs=None,
    zeros=None,
    carriage=(),
    table=(),
    first=(0, 0, 0, 0, 0, 0),
    payload=0.0,
) -> Robot:
    """A machine by Denavit-Hartenberg rows (alpha, a, theta, d)."""
    n = len(rows)
    kinds, signs, zeros = kinds or "R" * n, signs or [1] * n, zeros or [0] * n
    text = f'schema = 1\nname = "{name}"\nstanding = "assumed"\n'
    more, T, joints = _carriage(carriage, table, first)
    text += more if (carriage or table or any(first)) else ""
    before = len(joints)
    text += f'\n[arm]\nconvention = "{"modified" if modified else "standard"}"\ndh = [\n'
    text += "".join(f"  [{', '.join(str(x) for x in row)}],\n" for row in rows) + "]\n"
    if "P" in kinds:
        text += f'kinds = "{kinds}"\n'
    if any(s != 1 for s in signs):
        text += f"signs = {list(signs)}\n"
    if any(zeros):
        text += f"offsets_deg = {list(zeros)}\n"
    ends = []
    for k, (alpha, a, theta, d) in enumerate(rows):
        screw, bend = place(0, 0, d, (0, 0, theta)), place(a, 0, 0, (alpha, 0, 0))
        slides = kinds[k] == "P"
        low, high = (np.array(spans[k]) * (1.0 if slides else D)).tolist()
        speed = speeds[k] * (1.0 if slides else D)
        zero = zeros[k] * (1.0 if slides else D)
        pre = T @ bend if modified else T
        joints.append(
            Joint(
                f"A{k + 1}", pre, low, high, speed, slides, signs[k], zero, soft=soft[k], big=1.0 if slides else 700.0
            )
        )
        T = screw if modified else screw @ bend
        ends.append(T)
    lumps = []
    if payload:
        text += f"\n[load]\npayload_kg = {payload}\n"
    text += _tool(tool)
    for m, (axis, kg, at) in enumerate(masses):
        text += f'\n[[mass]]\nname = "part {m + 1}"\nafter = "A{axis}"\nmass_kg = {kg}\ncenter_mm = {list(at)}\n'
        at = (ends[axis - 1] @ [*at, 1.0])[:3]
        lumps.append(Lump(before + axis - 1, kg, tuple(at.tolist())))
    ready = [x * (1.0 if j.slides else D) for x, j in zip(ready, joints, strict=True)]
    return Robot(name, tuple(joints), T, frame(tool), tuple(lumps), tuple(ready), {"cell.toml": text}, payload)


def _by_urdf(name, links, tool, ready, payload=0.0, first=(0, 0, 0, 0, 0, 0)) -> Robot:
    """A machine by a URDF: links of (xyz mm, rpy deg, axis, span, speed, soft, kg, centre mm)."""
    text = f'schema = 1\nname = "{name}"\nstanding = "datasheet"\n'
    if any(first):
        text += f"\n[kinematics]\nbase_to_first = {list(first)}\nbase_follows_table = false\n"
    text += '\n[arm]\nurdf = "robot.urdf"\n'
    text += f"\n[load]\npayload_kg = {payload}\n" if payload else ""
    xml = f'<?xml version="1.0"?>\n<robot name="{name}">\n  <link name="foot"/>\n'
    turns = {"x": place(rpy=(0, 90, 0)), "y": place(rpy=(-90, 0, 0)), "z": np.eye(4)}
    T, joints, lumps, parent = frame(first), [], [], "foot"
    for k, (xyz, rpy, axis, span, speed, soft, kg, at) in enumerate(links):
        slides = axis.isupper()
        along = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}[axis.lower()]
        unit = 1e-3 if slides else D
        turn = turns[axis.lower()]
        low, high = span
        centre, origin = (" ".join(str(x / 1000) for x in v) for v in (at, xyz))
        turned = " ".join(repr(float(x * D)) for x in rpy)
        xml += (
            f'  <link name="link_{k + 1}">\n    <inertial>\n      <origin xyz="{centre}"/>\n      <mass value="{kg}"/>\n'
            '      <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>\n    </inertial>\n  </link>\n'
            f'  <joint name="joint_{k + 1}" type="{"prismatic" if slides else "revolute"}">\n'
            f'    <parent link="{parent}"/>\n    <child link="link_{k + 1}"/>\n'
            f'    <origin xyz="{origin}" rpy="{turned}"/>\n    <axis xyz="{along}"/>\n'
            f'    <limit lower="{low * unit:.6f}" upper="{high * unit:.6f}" velocity="{speed * unit:.4f}" effort="500"/>\n'
            "  </joint>\n"
        )
        mine = 1.0 if slides else D
        joints.append(
            Joint(
                f"A{k + 1}",
                T @ place(*xyz, rpy) @ turn,
                low * mine,
                high * mine,
                speed * mine,
                slides,
                soft=soft,
                big=1.0 if slides else 500.0,
            )
        )
        T, parent = np.linalg.inv(turn), f"link_{k + 1}"
        if kg:
            lumps.append(Lump(k, kg, tuple((T @ [*at, 1.0])[:3].tolist())))
    files = {"cell.toml": text + _tool(tool), "robot.urdf": xml + "</robot>\n"}
    ready = tuple(x * (1.0 if j.slides else D) for x, j in zip(ready, joints, strict=True))
    return Robot(name, tuple(joints), T, frame(tool), tuple(lumps), ready, files, payload)


BIG_ROWS = [[-90, 320, 0, 670], [0, 1075, -90, 0], [-90, 225, 0, 0], [90, 0, 0, 1280], [-90, 0, 0, 0], [0, 0, 180, 235]]
BIG_SPANS = [(-120, 120), (-40, 50), (-60, 60), (-170, 170), (-100, 100), (-170, 170)]
BIG_SPEEDS = [110, 100, 110, 140, 130, 200]
BIG_SOFT = [2.2e-7, 2.6e-7, 3.4e-7, 1.5e-6, 1.6e-6, 3e-6]
BIG_MASS = [(1, 410, (-150, 80, 20)), (2, 230, (-540, 0, 160)), (3, 290, (-60, 0, 240)), (5, 70, (0, 0, 90))]


def _big(name="spot_welder", tool=(180, 0, 420, 0, 30, 0), **more) -> Robot:
    ready = more.pop("ready", (0, 5, 5, 20, -50, 30))
    return _by_rows(name, BIG_ROWS, BIG_SPANS, BIG_SPEEDS, BIG_SOFT, BIG_MASS, tool, ready, payload=150.0, **more)


def _palletiser() -> Robot:
    rows = [[-90, 350, 0, 850], [0, 1150, -90, 0], [0, 1250, 90, 0], [90, 250, 0, 0], [0, 0, 0, -300]]
    spans = [(-150, 150), (-40, 70), (-15, 95), (-200, 200), (-180, 180)]
    robot = _by_rows(
        "palletiser",
        rows,
        spans,
        [130, 110, 110, 130, 300],
        [2e-7, 2.4e-7, 3e-7, 0, 2e-6],
        [(1, 500, (-100, 0, 0)), (2, 190, (-560, 0, 200)), (3, 170, (-700, 0, 0)), (5, 45, (0, 0, 50))],
        (0, 0, 180, 0, 180, 0),
        (0, 20, 40, 20, 10),
        payload=110.0,
        signs=[1, 1, -1, 1, 1],
    )
    return replace(robot, tied=((3, ((2, 1.0), (1, -1.0))),))  # rods hold the hand upright


def _seven() -> Robot:
    rows = [
        [0, 0, 0, 340],
        [-90, 0, 0, 0],
        [90, 0, 0, 400],
        [90, 0, 0, 0],
        [-90, 0, 0, 400],
        [-90, 0, 0, 0],
        [90, 0, 0, 126],
    ]
    spans = [(-160, 160), (-80, 80), (-150, 150), (-110, 110), (-150, 150), (-110, 110), (-160, 160)]
    return _by_rows(
        "seven_axes",
        rows,
        spans,
        [85, 85, 100, 75, 130, 135, 135],
        [1.2e-5, 1.4e-5, 2e-5, 2.2e-5, 5e-5, 5e-5, 8e-5],
        [(2, 7.5, (0, 60, 60)), (4, 6.0, (0, -55, 40)), (6, 3.2, (0, 20, 10))],
        (0, 0, 150, 0, 0, 0),
        (10, 30, -20, -70, 15, 60, 0),
        modified=True,
        payload=6.0,
    )


def _seven_urdf() -> Robot:
    links = [
        ((0, 0, 157), (0, 0, 0), "z", (-170, 170), 100, 2e-5, 2.4, (0, 0, 60)),
        ((0, 0, 128), (0, 0, 0), "y", (-110, 110), 100, 2.2e-5, 2.2, (0, 20, 100)),
        ((0, 0, 210), (0, 0, 0), "z", (-170, 170), 120, 3e-5, 1.9, (0, 10, 70)),
        ((0, -12, 210), (0, 0, 0), "y", (-130, 130), 120, 3e-5, 1.8, (0, 15, 90)),
        ((0, 12, 208), (0, 0, 0), "z", (-170, 170), 150, 6e-5, 1.2, (0, 0, 40)),
        ((0, 0, 106), (0, 0, 0), "y", (-110, 110), 150, 6e-5, 1.1, (0, 5, 40)),
        ((0, 0, 60), (0, 0, 0), "z", (-170, 170), 180, 1e-4, 0.5, (0, 0, 20)),
    ]
    return _by_urdf("service_arm", links, (0, 0, 120, 0, 0, 0), (15, -40, 20, -70, -20, -50, 10), payload=2.0)


def _hanging() -> Robot:
    links = [
        ((0, 0, 430), (0, 0, 0), "z", (-160, 160), 175, 1.5e-6, 60, (20, 0, -60)),
        ((150, 0, 0), (0, 0, 0), "y", (-60, 90), 175, 1.7e-6, 45, (0, 60, 350)),
        ((0, 0, 700), (0, 0, 0), "y", (-90, 60), 180, 2.6e-6, 35, (90, 0, 80)),
        ((320, 0, 115), (0, 0, 0), "x", (-180, 180), 320, 9e-6, 14, (200, 0, 0)),
        ((475, 0, 0), (0, 0, 0), "y", (-110, 110), 320, 9e-6, 6, (30, 0, 0)),
        ((100, 0, 0), (0, 0, 0), "x", (-180, 180), 420, 2e-5, 1.5, (20, 0, 0)),
    ]
    return _by_urdf(
        "hanging_arm", links, (160, 30, 0, 0, 70, 0), (5, 25, -20, 15, 45, -10), 10.0, (0, 0, 2600, 0, 180, 0)
    )


def _painter() -> Robot:
    rows = [[-90, 250, 0, 620], [0, 850, -90, 0], [-90, 110, 0, 0], [60, 0, 0, 980], [-60, 0, 0, 95], [0, 0, 0, 160]]
    spans = [(-120, 120), (-50, 70), (-60, 60), (-300, 300), (-300, 300), (-300, 300)]
    return _by_rows(
        "painter",
        rows,
        spans,
        [110, 110, 110, 300, 300, 400],
        [1.4e-6, 1.6e-6, 2.2e-6, 1e-5, 1e-5, 2e-5],
        [(2, 60, (-420, 0, 60)), (3, 70, (-20, 0, 180)), (5, 9, (0, 0, 20))],
        (80, 0, 210, 0, 45, 0),
        (10, 10, 5, 40, 100, 20),
        payload=5.0,
    )


def _desktop() -> Robot:
    links = [
        ((0, 0, 90), (0, 0, 0), "z", (-150, 150), 150, 2e-4, 0.5, (0, 0, 20)),
        ((0, 0, 45), (0, 0, 0), "y", (-60, 80), 150, 2.5e-4, 0.45, (0, 0, 60)),
        ((0, 0, 135), (0, 0, 0), "y", (-100, 60), 150, 3e-4, 0.35, (30, 0, 20)),
        ((61, 0, 38), (0, 0, 0), "x", (-160, 160), 200, 8e-4, 0.2, (20, 0, 0)),
        ((59, 0, 0), (0, 0, 0), "y", (-100, 100), 200, 8e-4, 0.12, (10, 0, 0)),
        ((70, 0, 0), (0, 0, 0), "x", (-175, 175), 300, 1e-3, 0.03, (5, 0, 0)),
    ]
    return _by_urdf("desktop_arm", links, (35, 0, 0, 0, 90, 0), (10, 20, -15, 30, 40, 20), payload=0.3)


def _cobot(name, carriage=(), first=(0, 0, 0, 0, 0, 0), ready=()) -> Robot:
    rows = [[90, 0, 0, 152], [0, -425, 0, 0], [0, -392, 0, 0], [90, 0, 0, 127], [-90, 0, 0, 100], [0, 0, 0, 100]]
    spans = [(-170, 170), (-140, -20), (-130, 130), (-180, 180), (-170, 170), (-180, 180)]
    return _by_rows(
        name,
        rows,
        spans,
        [120, 120, 180, 180, 180, 180],
        [9e-6, 1e-5, 1.2e-5, 4e-5, 4e-5, 5e-5],
        [
            (1, 7.4, (0, -20, 0)),
            (2, 13.0, (210, 0, 110)),
            (3, 3.8, (180, 0, 30)),
            (4, 2.1, (0, 0, 10)),
            (6, 0.4, (0, 0, -20)),
        ],
        (0, 40, 160, 0, 0, 0),
        ready or (20, -80, 90, -100, -80, 10),
        carriage=carriage,
        first=first,
        payload=5.0,
    )


def _gantry() -> Robot:
    links = [
        ((0, 0, 0), (0, 0, 0), "X", (0, 2400), 600, 0, 0, (0, 0, 0)),
        ((0, 0, 0), (0, 0, 0), "Y", (0, 1500), 600, 0, 140, (0, 0, 900)),
        ((0, 0, 900), (0, 0, 0), "Z", (-500, 0), 400, 0, 60, (0, 0, 100)),
        ((0, 0, -120), (0, 0, 0), "z", (-200, 200), 120, 0, 12, (0, 0, 0)),
        ((0, 60, -80), (0, 0, 0), "x", (-100, 100), 120, 0, 9, (0, 0, -40)),
    ]
    return _by_urdf("gantry_head", links, (0, 0, -190, 0, 180, 0), (1200, 750, -250, 20, 15))


def _scara() -> Robot:
    rows = [[0, 350, 0, 310], [180, 250, 0, 0], [0, 0, 0, 80], [0, 0, 0, 0]]
    spans = [(-120, 120), (-130, 130), (0, 160), (-180, 180)]
    return _by_rows(
        "scara_press",
        rows,
        spans,
        [360, 500, 900, 1200],
        [1e-5, 2e-5, 0, 0],
        [(1, 9, (-160, 0, 0)), (2, 6, (-60, 0, 0))],
        (25, 0, 60, 0, 0, 0),
        (20, 60, 70, 0),
        kinds="RRPR",
        payload=2.0,
    )


def _wafer() -> Robot:
    links = [
        ((0, 0, 300), (0, 0, 0), "z", (-160, 160), 180, 2e-5, 6, (0, 0, 0)),
        ((0, 0, 0), (0, 0, 0), "Z", (0, 350), 300, 0, 5, (0, 0, 0)),
        ((0, 0, 120), (0, 0, 0), "X", (80, 520), 700, 0, 2, (-40, 0, 0)),
        ((140, 0, 0), (0, 0, 0), "z", (-170, 170), 300, 1e-4, 0.5, (10, 0, 0)),
    ]
    return _by_urdf("wafer_handler", links, (110, 0, 10, 0, 0, 0), (30, 150, 300, 20))


PLATE = ("E2", "workpiece", False, [90, 1150, 0, -420], (-175, 175), 60 * D)


def _welding() -> Robot:
    rows = [[-90, 200, 90, 550], [0, 614, -90, 0], [-90, 120, 0, 0], [90, 0, 0, 640], [-90, 0, 0, 0], [0, 0, 180, 100]]
    spans = [(-120, 120), (-50, 60), (-60, 60), (-160, 160), (-110, 110), (-170, 170)]
    carriage = ("E1", "carriage", True, [-90, 0, 0, 0], (-1800, 1800), 900.0)
    return _by_rows(
        "weld_cell",
        rows,
        spans,
        [160, 150, 160, 340, 340, 500],
        [1.5e-6, 1.8e-6, 2.4e-6, 8e-6, 9e-6, 2e-5],
        [(1, 70, (-70, 0, 20)), (2, 45, (-300, 0, 60)), (3, 50, (-20, 0, 90)), (5, 7, (0, 0, 30))],
        (25, 0, 330, 0, 35, 0),
        (20, 100, 0, 10, -5, 15, -45, 20),
        carriage=[carriage],
        table=[PLATE],
        payload=8.0,
    )


def _lifted() -> Robot:
    lift = ("E1", "carriage", True, [0, 0, 0, 0], (0, 900), 120.0)
    return _cobot("lift_cobot", [lift], ready=(400, 20, -80, 90, -100, -80, 10))


FLEET: dict[str, Robot] = {
    "big": _big(),
    "big_rail": _big(
        "spot_on_rail",
        carriage=[("E1", "carriage", True, [90, 0, 0, 0], (0, 6000), 1200.0)],
        first=(0, 0, 0, 0, 0, -90),
        ready=(2500, 0, 5, 5, 20, -50, 30),
    ),
    "palletiser": _palletiser(),
    "seven": _seven(),
    "service": _seven_urdf(),
    "hanging": _hanging(),
    "painter": _painter(),
    "desktop": _desktop(),
    "cobot": _cobot("bench_cobot"),
    "lift": _lifted(),
    "gantry": _gantry(),
    "scara": _scara(),
    "wafer": _wafer(),
    "weld": _welding(),
}
