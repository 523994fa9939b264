"""Six machines: three of the cells that are shipped, read from their files by other code, and three cells of their own."""

from __future__ import annotations

import tomllib

import numpy as np

from gap.ninth_author.arms import CELLS, Arm, frame

__all__ = ["MACHINES", "machine"]


def _shipped(name, middle, spread, soft, masses=None, **more) -> Arm:
    cell = tomllib.loads((CELLS / name / "cell.toml").read_text())
    joints = [j for j in cell["joint"] if j["role"] != "roll"]
    names, kin = [j["name"] for j in joints], cell["kinematics"]
    pre = [np.eye(4) for _ in joints]
    pre[0] = frame(kin["base_to_first"])
    rows = np.array([[j["dh"][k] for k in ("alpha_deg", "a_mm", "theta_deg", "d_mm")] for j in joints], float)
    slides = tuple(j["type"] == "prismatic" for j in joints)
    rows[:, [0, 2]], rows[:, [1, 3]] = np.radians(rows[:, [0, 2]]), rows[:, [1, 3]] / 1e3
    told = [
        (names.index(m["after"]), m["mass_kg"], tuple(np.array(m["center_mm"]) / 1e3)) for m in cell.get("mass", [])
    ]
    return Arm(
        name=name,
        names=tuple(names),
        rows=rows,
        slides=slides,
        pre=tuple(pre),
        tool=frame(kin["wrist_to_flange"]) @ frame(cell["tool"]["flange_to_tool"]),
        sign=np.array([j["axis"]["sign"] for j in joints], float),
        off=np.array([j["axis"].get("offset_deg", j["axis"].get("offset_mm", 0.0)) for j in joints], float),
        middle=np.array(middle, float),
        spread=np.array(spread, float),
        soft=np.array(soft),
        masses=tuple(masses or told),
        shipped=name,
        root=frame(kin["foot_to_root"]),
        **more,
    )


def _own(name, title, dh, middle, spread, soft, masses, tool, told_masses=True, kinds="", payload=0.0, **more) -> Arm:
    kinds = kinds or "R" * len(dh)
    names = tuple(f"A{i + 1}" for i in range(len(dh)))
    lines = [
        "schema = 1",
        f'name = "{name}"',
        f'title = "{title}"',
        'standing = "assumed"',
        "",
        "[arm]",
        'convention = "standard"',
    ]
    lines += ["dh = [", *(f"  [{', '.join(f'{v:g}' for v in row)}]," for row in dh), "]"]
    if "P" in kinds:
        lines.append(f'kinds = "{kinds}"')
    lines += ["", "[tool]", f"flange_to_tool = [{', '.join(f'{v:g}' for v in tool)}]"]
    lines += ["", "[load]", f"payload_kg = {payload:g}"]
    for i, kg, c in masses if told_masses else ():
        at = ", ".join(f"{1e3 * v:g}" for v in c)
        lines += ["", "[[mass]]", f'name = "{names[i]} link"', f'after = "{names[i]}"', f"mass_kg = {kg:g}"]
        lines.append(f"center_mm = [{at}]")
    rows = np.array(dh, float)
    rows[:, [0, 2]], rows[:, [1, 3]] = np.radians(rows[:, [0, 2]]), rows[:, [1, 3]] / 1e3
    return Arm(
        name=name,
        names=names,
        rows=rows,
        slides=tuple(k == "P" for k in kinds),
        pre=tuple(np.eye(4) for _ in dh),
        tool=frame(tool),
        sign=np.ones(len(dh)),
        off=np.zeros(len(dh)),
        middle=np.array(middle, float),
        spread=np.array(spread, float),
        soft=np.array(soft),
        masses=tuple(masses),
        text="\n".join(lines) + "\n",
        **more,
    )


def _kr15() -> Arm:
    d = np.radians
    return _shipped(
        "kr15_track_table",
        middle=[d(180.0), 0.0, d(180.0), d(-80.0), d(10.0), d(10.0), d(80.0), d(15.0)],
        spread=[0.9, 0.5, 0.35, 0.25, 0.3, 0.6, 0.35, 0.7],
        soft=[0.0, 0.0, 1.1e-6, 1.0e-6, 1.8e-6, 7e-6, 8e-6, 1.4e-5],
        masses=[
            (3, 46.0, (-0.36, 0.01, 0.0)),
            (4, 52.0, (-0.05, 0.04, 0.03)),
            (5, 21.0, (0.0, 0.17, 0.0)),
            (7, 17.0, (0.0, -0.03, -0.15)),
        ],
    )


def _rx160() -> Arm:
    d = np.radians
    return _shipped(
        "rx160_tracker",
        middle=[d(5.0), d(-60.0), d(165.0), d(10.0), d(50.0), d(-20.0)],
        spread=[0.9, 0.4, 0.4, 0.9, 0.6, 1.2],
        soft=[1.4e-6, 1.2e-6, 2.4e-6, 9e-6, 1.1e-5, 2e-5],
        masses=[
            (0, 95.0, (-0.1, 0.12, 0.0)),
            (1, 58.0, (-0.45, 0.0, 0.1)),
            (2, 33.0, (0.0, -0.04, 0.05)),
            (3, 22.0, (0.0, 0.2, 0.0)),
            (5, 9.0, (0.01, 0.0, 0.03)),
        ],
    )


def _kr500() -> Arm:
    d = np.radians
    return _shipped(
        "kr500_afp",
        middle=[d(175.0), d(-75.0), d(5.0), d(10.0), d(75.0), d(10.0)],
        spread=[0.6, 0.3, 0.35, 0.6, 0.5, 0.9],
        soft=[2.2e-7, 2.0e-7, 2.9e-7, 1.6e-6, 1.7e-6, 3e-6],
        speed=0.35,
    )


def _ur10e() -> Arm:
    """Universal Robots' published Denavit-Hartenberg rows, masses and centres of mass of the UR10e."""
    d = np.radians
    return _own(
        "ur10e",
        "UR10e by its maker's published Denavit-Hartenberg rows, bare",
        dh=[
            [90, 0, 0, 180.7],
            [0, -612.7, 0, 0],
            [0, -571.55, 0, 0],
            [90, 0, 0, 174.15],
            [-90, 0, 0, 119.85],
            [0, 0, 0, 116.55],
        ],
        middle=[d(20.0), d(-80.0), d(95.0), d(-105.0), d(-85.0), d(10.0)],
        spread=[1.0, 0.4, 0.5, 0.7, 0.6, 1.2],
        soft=[2.6e-5, 2.4e-5, 3.6e-5, 1.0e-4, 1.0e-4, 1.2e-4],
        masses=[
            (0, 7.369, (0.021, 0.0, 0.027)),
            (1, 13.051, (0.38, 0.0, 0.158)),
            (2, 3.989, (0.24, 0.0, 0.068)),
            (3, 2.1, (0.0, 0.007, 0.018)),
            (4, 1.98, (0.0, 0.007, 0.018)),
            (5, 4.2, (0.01, 0.0, 0.06)),
        ],
        tool=[0, 60, 185, 0, 180, 0],
        payload=3.6,
        speed=0.7,
    )


def _long() -> Arm:
    """A long reach by a parallelogram, as serial equivalents: class of 240 kg at 3.2 m, lengths and masses assumed."""
    d = np.radians
    return _own(
        "long_reach",
        "arm of long reach, its forearm driven through a parallelogram",
        dh=[
            [-90, 480, 0, 985],
            [0, 1250, -90, 0],
            [-90, 70, 0, 0],
            [90, 0, 0, 1520],
            [-90, 0, 0, 0],
            [0, 0, 0, 275],
        ],
        middle=[d(10.0), d(10.0), d(5.0), d(10.0), d(60.0), d(-15.0)],
        spread=[0.6, 0.35, 0.35, 0.8, 0.5, 1.0],
        soft=[3.4e-7, 2.6e-7, 3.9e-7, 2.2e-6, 2.6e-6, 4.5e-6],
        masses=[
            (0, 540.0, (-0.2, 0.1, 0.0)),
            (1, 300.0, (-0.62, 0.0, 0.05)),
            (2, 280.0, (-0.05, -0.05, -0.12)),
            (3, 105.0, (0.0, -0.5, 0.0)),
            (5, 190.0, (0.06, 0.0, 0.2)),
        ],
        tool=[120, 0, 420, 0, 180, 0],
        payload=150.0,
        parallel=True,
        speed=0.35,
    )


def _scara() -> Arm:
    """Two level links on a column's slide, and a quill that turns: lengths assumed, masses told to nobody."""
    return _own(
        "scara_column",
        "level arm of 1.1 m on the slide of a column",
        dh=[[0, 160, 0, 620], [0, 600, 0, 0], [180, 500, 0, 0], [0, 0, 0, 240]],
        middle=[0.4, 0.2, 0.9, -0.3],
        spread=[0.25, 0.7, 0.6, 1.5],
        soft=[2.0e-8, 2.0e-6, 3.0e-6, 2.0e-5],
        masses=[
            (0, 60.0, (0.0, 0.0, 0.0)),
            (1, 30.0, (-0.3, 0.0, 0.0)),
            (2, 22.0, (-0.2, 0.0, 0.0)),
            (3, 6.0, (0.0, 0.0, 0.0)),
        ],
        tool=[40, 0, 150, 0, 180, 0],
        told_masses=False,
        kinds="PRRR",
        payload=4.0,
        speed=0.6,
    )


MACHINES = {"kr15": _kr15, "rx160": _rx160, "kr500": _kr500, "ur10e": _ur10e, "long": _long, "scara": _scara}


def machine(name) -> Arm:
    """One of `MACHINES`, by its name."""
    return MACHINES[name]()
