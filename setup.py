"""The wheel's build: puts cells and samples, which stand beside the package in the repository, into it as camrob/_shipped/."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).resolve().parent
# what golden files, pictures and the makers of samples are for is the repository's own
SHIPPED = {"cells": ("*",), "toolpaths": ("*.cls", "*.stl", "setup.toml", "README.md")}


class BuildWithCellsAndSamples(build_py):
    """As setuptools' own; an editable install needs nothing, camrob finds the folders beside it."""

    def run(self):
        """Copy the package's modules, then what is shipped with them."""
        super().run()
        if self.editable_mode:
            return
        for kind, patterns in SHIPPED.items():
            for pattern in patterns:
                for file in sorted((HERE / kind).glob(f"*/{pattern}")):
                    if file.is_file() and file.suffix != ".py":
                        target = Path(self.build_lib) / "camrob" / "_shipped" / kind / file.parent.name / file.name
                        target.parent.mkdir(parents=True, exist_ok=True)
                        shutil.copyfile(file, target)


setup(cmdclass={"build_py": BuildWithCellsAndSamples})
