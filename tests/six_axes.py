"""An arm of our own making as a URDF: six turning axes like an ordinary robot's, its wrist in a point."""

from __future__ import annotations

from pathlib import Path

_AXES = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")
_PLACES = ("0 0 0.5", "0.2 0 0", "0 0 0.9", "0 0 0.2", "1 0 0", "0.15 0 0")
_LIMITS = ("-2.9 2.9", "-1.1 1.9", "-3.1 1.2", "-3.4 3.4", "-2.1 2.1", "-6.1 6.1")


def six_axes(folder: Path) -> Path:
    """Write the arm's URDF, whose last link is its plate with z along axis 6."""
    links = "".join(f'<link name="l{k}"/>' for k in range(7)) + '<link name="plate"/>'
    joints = []
    for k, (axis, place, limits) in enumerate(zip(_AXES, _PLACES, _LIMITS, strict=True)):
        lower, upper = limits.split()
        joints.append(
            f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="{place}"/>'
            f'<axis xyz="{axis}"/><limit lower="{lower}" upper="{upper}" velocity="3" effort="9"/></joint>'
        )
    plate = '<joint name="p" type="fixed"><parent link="l6"/><child link="plate"/><origin rpy="0 1.5707963267948966 0"/></joint>'
    file = folder / "six.urdf"
    file.write_text(f'<robot name="six">{links}{"".join(joints)}{plate}</robot>')
    return file
