"""Kinematics of many postures at once through pytorch-kinematics, on the CPU or a GPU, in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.world import segments

__all__ = ["BatchedKinematics"]

Array = NDArray[np.float64]


class BatchedKinematics:
    """A cell's chain base -> tool, and its bare arm root -> mounting plate, as pytorch-kinematics chains.

    Where thousands of postures are asked for at once: seeds, maps, planners. One posture at a time is the compiled
    kernels' business. Postures go through in chunks of `chunk`, which bounds the memory (about 10 kB a posture; larger
    chunks suit a GPU); results come back as NumPy arrays. torch is imported on construction only. The chains are built
    from float64 matrices, as the library's URDF reader works in float32.
    """

    def __init__(self, cell: Cell, device: str = "cpu", *, chunk: int = 1024) -> None:
        import torch
        from pytorch_kinematics.chain import Chain, SerialChain
        from pytorch_kinematics.frame import Frame, Joint, Link
        from pytorch_kinematics.transforms import Transform3d

        if chunk < 1:
            raise ValueError(f"chunk is {chunk}, at least 1 is needed")
        self._torch = torch
        self._device = device
        self._chunk = chunk
        self._joints = len(cell)
        arm = cell.indices(Role.ARM)
        self._arm = slice(arm[0], arm[-1] + 1)
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
        self._chain = SerialChain(whole, "tool", dtype=torch.float64, device=device)
        self._arm_chain = SerialChain(whole, "flange", "root", dtype=torch.float64, device=device)

    def forward(self, q: Array) -> Array:
        """base_T_tool (N, 4, 4), the virtual roll included, of postures q (N, n)."""
        return self._map(lambda th: self._chain.forward_kinematics(th).get_matrix(), q, self._joints, (4, 4))

    def jacobian(self, q: Array) -> Array:
        """Geometric Jacobians (N, 6, n), rows (v, w) of the tool's origin in `base`, of postures q (N, n)."""
        return self._map(self._chain.jacobian, q, self._joints, (6, self._joints))

    def arm_forward(self, q_arm: Array) -> Array:
        """root_T_flange (N, 4, 4) of the arm's postures (N, 6)."""
        m = self._arm.stop - self._arm.start
        return self._map(lambda th: self._arm_chain.forward_kinematics(th).get_matrix(), q_arm, m, (4, 4))

    def arm_jacobian(self, q_arm: Array) -> Array:
        """Geometric Jacobians (N, 6, 6), rows (v, w) of the mounting plate in `root`, of the arm's postures (N, 6)."""
        m = self._arm.stop - self._arm.start
        return self._map(self._arm_chain.jacobian, q_arm, m, (6, m))

    def inverse_kf(self, q: Array) -> Array:
        """1/k_F (N,) of the bare arm at the mounting plate (eq. 16), 0 where it is singular, of postures q (N, n)."""
        return self.arm_inverse_kf(np.asarray(q, float)[:, self._arm])

    def arm_inverse_kf(self, q_arm: Array) -> Array:
        """The same of the arm's own postures (N, 6)."""
        return self._map(self._inverse_kf, q_arm, self._arm.stop - self._arm.start, ())

    def _inverse_kf(self, th: Any) -> Any:
        """1/k_F of the arm's postures: k_F = |H| |H^-1| / 6 in Frobenius norms, H being square."""
        H = self._arm_chain.jacobian(th).clone()
        H[:, :3] /= self._length
        H_inverse, fault = self._torch.linalg.inv_ex(H)
        product = H.square().sum((1, 2)) * H_inverse.square().sum((1, 2))
        return self._torch.where((fault == 0) & product.isfinite(), 6.0 / product.sqrt(), 0.0)

    def _map(self, function: Any, q: Array, width: int, shape: tuple[int, ...]) -> Array:
        """`function` over the postures, chunk by chunk. Raises ValueError for postures of another width."""
        values = np.asarray(q, float)
        if values.ndim != 2 or values.shape[1] != width:
            raise ValueError(f"postures have shape {values.shape}, expected (N, {width})")
        out = np.empty((len(values), *shape))
        with self._torch.no_grad():
            for start in range(0, len(values), self._chunk):
                part = slice(start, start + self._chunk)
                th = self._torch.tensor(values[part], dtype=self._torch.float64, device=self._device)
                out[part] = function(th).cpu().numpy()
        return out
