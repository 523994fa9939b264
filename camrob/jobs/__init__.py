"""The jobs behind the verbs of the command line, each one function."""

from __future__ import annotations

import sys
import warnings
from opcode import opmap
from types import ModuleType

__all__ = ["OldHome"]


class OldHome(ModuleType):
    """A verb's module, from which strangers imported the verb before `camrob` offered it: that works for one more version, and
    says so.
    """

    def __getattribute__(self, name: str) -> object:
        """An attribute as any module has it. Warns where the verb is imported by a module that is not camrob's own."""
        if name == super().__getattribute__("__name__").rpartition(".")[2]:
            asks = sys._getframe(1)
            imports = asks.f_lasti >= 0 and asks.f_code.co_code[asks.f_lasti] == opmap["IMPORT_FROM"]
            if imports and not str(asks.f_globals.get("__name__")).startswith("camrob"):
                warnings.warn(f"import {name} from camrob: camrob.{name}", DeprecationWarning, stacklevel=2)
        return super().__getattribute__(name)
