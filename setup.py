"""The wheel's build: puts cells and samples, which stand beside the package in the repository, into it as camrob/_shipped/.

The library of compiled kernels goes in, too, where `.ci/install` has made it of today's sources; the wheel then is for this
platform and this Python.
"""

import importlib.util
import shutil
import sys
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).resolve().parent
# what golden files, pictures and the makers of samples are for is the repository's own
SHIPPED = {"cells": ("*",), "toolpaths": ("*.cls", "*.stl", "setup.toml", "README.md")}


def compiled_kernels():
    """The libraries that were made of today's sources."""
    spec = importlib.util.spec_from_file_location("machine_code", HERE / "camrob" / "machine_code.py")
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return sorted((HERE / "camrob" / "warm" / "compiled").glob(f"kernels-{module.source_state()}-*"))


class WithMachineCode(Distribution):
    """A distribution that is for one platform if it carries machine code."""

    def has_ext_modules(self):
        """Whether it does."""
        return bool(compiled_kernels())


class BuildWithCellsAndSamples(build_py):
    """As setuptools' own; an editable install needs nothing, camrob finds the folders beside it."""

    def run(self):
        """Copy the package's modules, then what is shipped with them."""
        super().run()
        if self.editable_mode:
            return
        for library in compiled_kernels():
            target = Path(self.build_lib) / "camrob" / "warm" / "compiled" / library.name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(library, target)
        for kind, patterns in SHIPPED.items():
            for pattern in patterns:
                for file in sorted((HERE / kind).glob(f"*/{pattern}")):
                    if file.is_file() and file.suffix != ".py":
                        target = Path(self.build_lib) / "camrob" / "_shipped" / kind / file.parent.name / file.name
                        target.parent.mkdir(parents=True, exist_ok=True)
                        shutil.copyfile(file, target)


setup(cmdclass={"build_py": BuildWithCellsAndSamples}, distclass=WithMachineCode)
