"""Where batches of postures are evaluated: the compiled kernels on the CPU, or a GPU that was asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from camrob.cell.cell import Cell
from camrob.errors import InputError

if TYPE_CHECKING:
    from camrob.redundancy.planning.scan_batched import Score

__all__ = ["DEVICES", "batch_score", "check_device"]

DEVICES = ("cpu", "cuda")
_CHUNK = 65_536  # postures that go to a GPU at a time: some hundred MB there


def check_device(device: str) -> None:
    """Raises InputError for a device that is unknown or not there. torch is imported for a GPU only."""
    if device not in DEVICES:
        raise InputError(f"--device {device!r} is unknown", hint=f"use {' or '.join(DEVICES)}")
    if device == "cuda":
        import torch

        if not torch.cuda.is_available():
            raise InputError("--device cuda: there is no GPU that torch can use", hint="leave --device out")


def batch_score(cell: Cell, device: str) -> Score | None:
    """What scores the planner's batches on a GPU; None for the CPU, where the compiled kernels do it themselves."""
    if device == "cpu":
        return None
    from camrob.kinematics.batched import BatchedKinematics

    return BatchedKinematics(cell, device, chunk=_CHUNK).arm_inverse_kf
