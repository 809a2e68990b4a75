"""`microslip serve` as the official client of UM-Bridge sees it."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import microslip
import numpy as np
import pytest

umbridge = pytest.importorskip("umbridge")

from conftest import write_study


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Where a server of the study of the tests answers; the program is named by MICROSLIP."""
    program = os.environ.get("MICROSLIP")
    if program is None:
        pytest.skip("MICROSLIP does not name the program")
    study = write_study(tmp_path_factory.mktemp("served"))
    command = [program, "serve", str(study), "--port", "0", "--anchors", "8", "--threads", "2"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        first = server.stdout.readline()
        yield first.split()[-1]
        server.terminate()
        assert server.wait(timeout=20) == 0


def test_the_client_gets_what_the_package_gives(url: str, model: microslip.Model) -> None:
    assert umbridge.supported_models(url) == ["forward"]
    served = umbridge.HTTPModel(url, "forward")
    assert served.get_input_sizes() == [2] and served.get_output_sizes() == [2, 2]
    assert served.supports_evaluate() and not served.supports_gradient()
    for point in ([1.0, 0.4], [0.5, 0.3]):
        frequency_hz, amplitude_m, _ = model(np.array([point]))
        np.testing.assert_array_equal(served([point]), [frequency_hz[0], amplitude_m[0]])
        one = served([point], {"level": model.levels[1]})
        np.testing.assert_array_equal(one, [[frequency_hz[0, 1]], [amplitude_m[0, 1]]])


def test_what_is_wrong_is_an_error_and_the_server_lives_on(url: str) -> None:
    served = umbridge.HTTPModel(url, "forward")
    for wrong, rule in (
        ([[1.0, -0.4]], "friction_coefficient = -0.4"),
        ([[1.0]], "must be one value for each of"),
    ):
        with pytest.raises(Exception, match=rule):
            served(wrong)
    with pytest.raises(Exception, match="level"):
        served([[1.0, 0.4]], {"level": 3.0})
    with pytest.raises(Exception):
        umbridge.HTTPModel(url, "backward")
    assert len(served([[1.0, 0.4]])) == 2
