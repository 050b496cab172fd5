"""Every snippet of the document runs."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from conftest import ROOT

PAGE = (ROOT / "docs" / "PYTHON.md").read_text()
SECTIONS = [section for section in PAGE.split("\n## ") if "```python\n" in section]


@pytest.mark.parametrize("section", SECTIONS, ids=lambda section: section.split("\n")[0])
def test_the_snippets_of_a_section_run(section: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("elephant.glb", "pair.glb"):
        shutil.copy(ROOT / "scenes" / name, tmp_path / name)
    shutil.copy(ROOT / "scenes" / "elephant.glb", tmp_path / "scene.glb")
    monkeypatch.chdir(tmp_path)
    snippets = re.findall(r"```python\n(.*?)```", section, flags=re.DOTALL)
    exec(compile("\n".join(snippets), section.split("\n", maxsplit=1)[0], "exec"), {"__name__": "document"})
