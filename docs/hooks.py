"""What mkdocs does beside its own: brings files that lie beside docs/ onto the site, and mends links to them.

A link in these pages is relative to its page, as it works in the repository. On the site a link to a file that was brought
leads to its page there; any other link out of docs/ becomes the name of what it led to.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
BROUGHT = {  # place on the site: file of the repository
    "contributing.md": "CONTRIBUTING.md",
    "changelog.md": "CHANGELOG.md",
    "explanation/diagnosis_limits.md": "camrob/gap/README.md",
    "explanation/gap_report.md": "tests/bench/gap/results/report.md",
    "explanation/calibration.png": "tests/bench/gap/results/calibration.png",
    "explanation/confusion.png": "tests/bench/gap/results/confusion.png",
    "explanation/peers.png": "tests/bench/peers.png",
    "explanation/conditioning.png": "toolpaths/carving/conditioning.png",
    "overview.png": "toolpaths/carving/overview.png",
} | {f"reference/cells/{p.parent.name}.md": str(p.relative_to(ROOT)) for p in sorted(ROOT.glob("cells/*/README.md"))}
_LINK = re.compile(r"\[([^\[\]]*)\]\(([\w./-]+)(#[\w-]*)?\)")


def on_files(files: Files, config: Any) -> Files:
    """The files that are brought, among those of docs/."""
    for place, source in BROUGHT.items():
        files.append(File.generated(config, place, abs_src_path=str(ROOT / source)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """A page's text with the links that lead out of docs/ mended."""
    here = (ROOT / BROUGHT.get(page.file.src_uri, f"docs/{page.file.src_uri}")).parent
    places = {source: place for place, source in BROUGHT.items()}

    def mended(link: re.Match[str]) -> str:
        target = (here / link[2]).resolve()
        if not target.exists() or (target.is_relative_to(ROOT / "docs") and here.is_relative_to(ROOT / "docs")):
            return link[0]  # mkdocs judges it
        name = target.relative_to(ROOT).as_posix()
        if name in places:
            return f"[{link[1]}]({os.path.relpath(places[name], os.path.dirname(page.file.src_uri))}{link[3] or ''})"
        return link[1] if link[1] == name else f"{link[1]} (`{name}`)"

    return _LINK.sub(mended, markdown)
