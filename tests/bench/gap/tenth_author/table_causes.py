"""What goes wrong with the table that turns the part."""

from __future__ import annotations

import numpy as np

from .chain import small
from .truth import Cause, Truth

__all__ = ["table_askew", "table_tips"]

D = np.pi / 180.0
_STAGE = "encoder_to_tcp"


def table_askew(tilt_deg, shift=(0, 0, 0)) -> Cause:
    """The table's axis stands askew and elsewhere, while the workpiece's frame was taken at its zero."""
    E = small(np.array(shift, float), np.array(tilt_deg, float) * D)

    def change(truth: Truth, part):
        return E @ part @ np.linalg.inv(E)

    def act(truth: Truth) -> None:
        truth.part.append(change)

    return Cause(
        "frame_table",
        _STAGE,
        ("E2",),
        ("position",),
        act,
        "measure the table's axis (a point on the plate at three or more angles) and enter its "
        "root anew; level the table",
        "mastering the arm, mending its gears",
        ("turntable",),
    )


def table_tips(name: str, micro_deg: float, soft=3.0, heavy_deg=40.0, height=0.0) -> Cause:
    """A heavy part beside the axis tips the plate, whose bearing is softer in one direction: as the table turns it wobbles."""

    def change(truth: Truth, part):
        phi = truth.q[:, truth.at(name)]
        heavy = phi + heavy_deg * D
        tilt = micro_deg * 1e-3 * D * np.stack([soft * np.sin(heavy), -np.cos(heavy), 0 * heavy], 1)
        flat = (
            small(np.array([0.0, 0, height]), np.zeros(3))
            @ small(np.zeros(3), tilt)
            @ small(np.array([0.0, 0, -height]), np.zeros(3))
        )
        return flat @ part

    def act(truth: Truth) -> None:
        truth.part.append(change)

    return Cause(
        "turntable",
        _STAGE,
        (name,),
        ("position", "load"),
        act,
        "put a dial gauge on the plate's rim and turn the table, with the part and without: "
        "balance the part or mend the bearing",
        "mastering the arm, changing frames",
        ("frame_table",),
    )
