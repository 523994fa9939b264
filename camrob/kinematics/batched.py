"""Conditioning of many postures of an arm at once through pytorch-kinematics, on the CPU or a GPU, in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.segments import segments

__all__ = ["BatchedKinematics"]

Array = NDArray[np.float64]


class BatchedKinematics:
    """A cell's bare arm, root -> mounting plate, as a chain of pytorch-kinematics.

    For a planner that asks for thousands of postures at once; one posture at a time is the compiled kernels' business.
    Postures go through in chunks of `chunk`, which bounds the memory (about 10 kB a posture; larger chunks suit a GPU);
    results come back as NumPy arrays. torch, of the extra `gpu`, is imported on construction only. The chain is built from
    float64 matrices, as the library's URDF reader works in float32.
    """

    def __init__(self, cell: Cell, device: str = "cpu", *, chunk: int = 1024) -> None:
        if chunk < 1:
            raise ValueError(f"chunk is {chunk}, at least 1 is needed")
        import torch
        from pytorch_kinematics.chain import Chain, SerialChain
        from pytorch_kinematics.frame import Frame, Joint, Link
        from pytorch_kinematics.transforms import Transform3d

        self._torch = torch
        self._device = device
        self._chunk = chunk
        self._axes = cell.arm_slice.stop - cell.arm_slice.start
        self._length = cell.condition_length
        root = Frame("base", link=Link("base"), joint=Joint(dtype=torch.float64))
        tip = root
        for segment in segments(cell):
            offset = torch.tensor(segment.parent_T_joint, dtype=torch.float64, device=device)
            joint = Joint(
                segment.joint.name if segment.joint else f"fixed-{segment.link}",
                offset=Transform3d(matrix=offset),
                joint_type="fixed" if not segment.joint else "prismatic" if segment.joint.prismatic else "revolute",
                dtype=torch.float64,
                device=device,
            )
            child = Frame(segment.link, link=Link(segment.link), joint=joint)
            tip.add_child(child)
            tip = child
        whole = Chain(root, dtype=torch.float64, device=device)
        self._arm = SerialChain(whole, "flange", "root", dtype=torch.float64, device=device)

    def arm_inverse_kf(self, q_arm: Array) -> Array:
        """1/k_F (N,) at the mounting plate (eq. 16) of the arm's postures (N, 6), rad, 0 where it is singular.

        Raises ValueError for postures of another width.
        """
        values = np.asarray(q_arm, float)
        if values.ndim != 2 or values.shape[1] != self._axes:
            raise ValueError(f"postures have shape {values.shape}, expected (N, {self._axes})")
        out = np.empty(len(values))
        with self._torch.no_grad():
            for start in range(0, len(values), self._chunk):
                part = slice(start, start + self._chunk)
                th = self._torch.tensor(values[part], dtype=self._torch.float64, device=self._device)
                out[part] = self._inverse_kf(th).cpu().numpy()
        return out

    def _inverse_kf(self, th: Any) -> Any:
        """k_F = |H| |H^-1| / 6 in Frobenius norms, H (K, 6, 6) being the Jacobians with lengths over the characteristic one."""
        H = self._arm.jacobian(th).clone()
        H[:, :3] /= self._length
        H_inverse, fault = self._torch.linalg.inv_ex(H)
        product = H.square().sum((1, 2)) * H_inverse.square().sum((1, 2))
        return self._torch.where((fault == 0) & product.isfinite(), 6.0 / product.sqrt(), 0.0)
