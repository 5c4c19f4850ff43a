"""What the documents point at is there: files, headings, tests, targets of make."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest
from places import ROOT
from stability import studies

DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])


def anchors(document: Path) -> set[str]:
    """What a link may have after its #, by the rule of GitHub's."""
    headings = re.findall(r"^#+ (.*)$", document.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda document: document.name)
def test_links(document: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", document.read_text()):
        name, _, anchor = target.partition("#")
        if name.startswith("https:"):
            continue
        path = document.parent / name if name else document
        assert path.is_file(), target
        assert not anchor or anchor in anchors(path), target


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda document: document.name)
def test_tests_and_targets(document: Path) -> None:
    text = document.read_text()
    for file, test in re.findall(r"\b(test_\w+\.py)(?:: (test_\w+))?", text):
        (path,) = (ROOT / "tests").rglob(file)
        assert f"def {test}" in path.read_text(), (file, test)
    for words in re.findall(r"test_stability\.py -k ([\w-]+)", text):
        assert any(words in str(study) for study in studies()), words
    targets = re.findall(r"^([a-z-]+)(?: [a-z -]+)?:(?!=)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    for target in re.findall(r"(?:`|^ {4})make\s+([a-z-]+)", text, re.MULTILINE):
        assert target in targets, target


def test_charts_keep_what_is_written_on_them() -> None:
    """`make chart-stability` shortens numbers in tags only: a tick at 0.001 is no 0.00."""
    drawn = '<path d="M 1.23456 7"/>\n   <text x="2.34567">0.001</text>'
    shorten = runpy.run_path(str(ROOT / "docs/chart_stability.py"))["shorten"]
    assert shorten(drawn) == '<path d="M 1.23 7"/>\n<text x="2.35">0.001</text>'
