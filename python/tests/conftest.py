"""The study of the tests: two blades and a damper from matrices, few samples, no error alert."""

from __future__ import annotations

import shutil
from pathlib import Path

import microslip
import pytest

STUDIES = Path(__file__).parents[2] / "studies"


def write_study(folder: Path, *changes: tuple[str, str]) -> Path:
    """A copy of the study in ``folder``, each pair of texts exchanged; its path."""
    shutil.copytree(STUDIES / "own-matrices", folder, dirs_exist_ok=True)
    path = folder / "study.toml"
    text = path.read_text(encoding="utf-8")
    for old, new in (("samples = 100", "samples = 12"), ("curve_samples = 20", "curve_samples = 2"), *changes):
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def study(tmp_path_factory: pytest.TempPathFactory) -> microslip.Study:
    return microslip.Study.read(write_study(tmp_path_factory.mktemp("study")))


@pytest.fixture(scope="session")
def results(study: microslip.Study, tmp_path_factory: pytest.TempPathFactory) -> microslip.Results:
    return study.run(output=tmp_path_factory.mktemp("results"), threads=2)


@pytest.fixture(scope="session")
def model(study: microslip.Study) -> microslip.Model:
    return study.model(anchors=8, threads=2)
