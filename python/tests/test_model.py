"""The model as a function, alone and called by other packages."""

from __future__ import annotations

import signal
import threading
import time
from pathlib import Path

import microslip
import numpy as np
import pytest
from conftest import STUDIES, write_study

POINTS = np.array([[1.0, 0.4], [0.5, 0.3], [2.0, 0.55]])


def table(results: microslip.Results) -> dict[str, np.ndarray]:
    pyarrow = pytest.importorskip("pyarrow")
    columns = pyarrow.table(results.samples)
    return {name: columns[name].to_numpy(zero_copy_only=False) for name in columns.column_names}


def test_points_agree_with_samples(
    study: microslip.Study, model: microslip.Model, results: microslip.Results
) -> None:
    """To the tolerance of a peak with other anchors, to the bit with those of the sample. Seen to fail with columns exchanged."""
    rows = table(results)
    first = rows["level"] == 1.0
    inputs = np.column_stack([rows[name][first] for name in model.input_names])
    frequency, amplitude, status = model(inputs)
    assert frequency.shape == amplitude.shape == status.shape == (12, 2)
    np.testing.assert_allclose(frequency.ravel(), rows["frequency_hz"], rtol=1e-8)
    np.testing.assert_allclose(amplitude.ravel(), rows["amplitude_m"], rtol=1e-6)
    assert status.ravel().tolist() == rows["status"].tolist()
    stored = study.model(anchors=7, results=results)
    assert stored.anchors == 7
    frequency, amplitude, _ = stored(inputs[7:10])
    assert frequency.ravel().tolist() == rows["frequency_hz"][14:20].tolist()
    assert amplitude.ravel().tolist() == rows["amplitude_m"][14:20].tolist()


def test_shapes_and_types(model: microslip.Model) -> None:
    """Seen to fail with a point of one dimension that gives two."""
    frequency, amplitude, status = model(POINTS)
    assert frequency.dtype == amplitude.dtype == np.float64
    assert status[0, 0] == "converged"
    assert model.levels == [1.0, 20.0]
    alone = model(POINTS[1])
    assert alone[0].shape == (2,)
    assert alone[0].tolist() == frequency[1].tolist()
    fortran = model(np.asfortranarray(POINTS.astype(np.float32)).astype(np.float64))
    assert fortran[0].shape == (3, 2)
    empty = model(np.empty((0, 2)))
    assert empty[0].shape == (0, 2)
    assert model(POINTS.tolist())[0].tolist() == frequency.tolist()
    frequency[0, 0] = 0.0  # the arrays are the caller's own


def test_threads_change_no_bit(study: microslip.Study, model: microslip.Model) -> None:
    """Seen to fail with other anchors."""
    other = study.model(anchors=8, threads=1)
    assert other(POINTS)[1].tobytes() == model(POINTS)[1].tobytes()


def test_values_that_cannot_be_meant_are_refused(model: microslip.Model) -> None:
    """Seen to fail without the check of the shape."""
    with pytest.raises(ValueError, match="row 1: friction_coefficient = -0.1: must be >= 0"):
        model([[1.0, 0.4], [1.0, -0.1]])
    with pytest.raises(microslip.StudyError, match="row 0: stiffness_scale = NaN"):
        model([[np.nan, 0.4]])
    for wrong in ([[1.0]], [1.0, 0.4, 0.3], 1.0, [[[1.0, 0.4]]]):
        with pytest.raises(microslip.StudyError, match=r"\(n, 2\), columns stiffness_scale, friction_coefficient"):
            model(wrong)


def test_what_is_not_found_is_data_and_scalar_says_so(tmp_path: Path) -> None:
    """Seen to fail with a missing number that is passed on as it is."""
    path = write_study(tmp_path, ("[300, 400]", "[330, 400]"))
    model = microslip.Study.read(path).model(anchors=0)
    points = [[1.0, 0.4], [0.8, 0.2]]
    frequency, amplitude, status = model(points)
    assert np.isnan(frequency[:, 1]).all() and np.isnan(amplitude[:, 1]).all()
    assert status[0].tolist() == ["converged", "no-peak-in-band"]
    with pytest.raises(ValueError, match=r"row 0: no-peak-in-band at level 20\.0: no number \(2 of 2 rows\)"):
        model.scalar(points, level=20.0)
    assert model.scalar(points, level=20.0, missing=0.0).tolist() == [0.0, 0.0]
    assert model.scalar(points, "frequency", level=1.0).tolist() == frequency[:, 0].tolist()
    assert model.scalar(points[0], level=1.0).shape == ()
    with pytest.raises(microslip.StudyError, match="level = None: must be a level"):
        model.scalar(points)
    with pytest.raises(microslip.StudyError, match="output = 'phase'"):
        model.scalar(points, output="phase", level=1.0)  # type: ignore[arg-type]


def test_a_study_without_random_inputs_is_a_function_of_nothing(tmp_path: Path) -> None:
    """Seen to fail with the number of points taken from the number of bytes."""
    text = (STUDIES / "own-matrices" / "study.toml").read_text(encoding="utf-8")
    inputs = text[text.index("[inputs.") : text.index("[", text.rindex("[inputs.") + 1)]
    model = microslip.Study.read(write_study(tmp_path, (inputs, ""))).model(anchors=0)
    assert model.input_names == []
    one, three = model(np.empty(0)), model(np.empty((3, 0)))
    assert one[0].shape == (2,) and three[0].shape == (3, 2)
    assert three[0].tolist() == [one[0].tolist()] * 3


def test_ctrl_c_ends_an_evaluation(model: microslip.Model) -> None:
    """Seen to fail with signals that nobody looks at: the exception then comes minutes later, with the last point."""
    points = np.random.default_rng(1).uniform([0.3, 0.2], [3.0, 0.6], (4000, 2))
    timer = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    begun = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        model(points)
    timer.join()
    assert time.monotonic() - begun < 10.0


def test_openturns_calls_the_model(model: microslip.Model) -> None:
    """Seen to fail with amplitudes for frequencies."""
    openturns = pytest.importorskip("openturns")

    def frequencies(X: object) -> list[list[float]]:
        return model.scalar(np.asarray(X), "frequency", level=20.0)[:, np.newaxis].tolist()

    function = openturns.PythonFunction(2, 1, func_sample=frequencies)
    law = openturns.JointDistribution([openturns.LogUniform(np.log(0.3), np.log(3.0)), openturns.Uniform(0.2, 0.6)])
    openturns.RandomGenerator.SetSeed(1)
    points = law.getSample(64)
    found = np.asarray(function(points)).ravel()
    assert found.tolist() == model(np.asarray(points))[0][:, 1].tolist()
    assert 320.0 < found.mean() < 325.0


def test_salib_finds_what_decides(model: microslip.Model) -> None:
    """At 1 N the damper hardly slips: the stiffness decides the frequency (0.999 in the README of the study).

    Seen to fail with columns exchanged.
    """
    sample = pytest.importorskip("SALib.sample.sobol")
    analyze = pytest.importorskip("SALib.analyze.sobol")
    names = model.input_names
    problem = {"num_vars": 2, "names": names, "bounds": [[np.log(0.3), np.log(3.0)], [0.2, 0.6]]}
    points = sample.sample(problem, 32, calc_second_order=False, seed=1)
    points[:, 0] = np.exp(points[:, 0])
    indices = analyze.analyze(problem, model.scalar(points, "frequency", level=1.0), calc_second_order=False, seed=1)
    assert indices["S1"][0] == pytest.approx(1.0, abs=0.1)
    assert indices["ST"][1] < 0.05


def test_emcee_finds_a_friction_coefficient(model: microslip.Model) -> None:
    """From the amplitude that the program gives at 0.4, the stiffness being known. Seen to fail with the other level."""
    emcee = pytest.importorskip("emcee")
    measured = 8.856958e-4

    def log_probability(theta: np.ndarray) -> np.ndarray:
        inside = (theta[:, 0] > 0.2) & (theta[:, 0] < 0.6)
        points = np.column_stack([np.ones(len(theta)), np.where(inside, theta[:, 0], 0.4)])
        misfit = (model.scalar(points, level=20.0) / measured - 1.0) / 0.02
        return np.where(inside, -0.5 * misfit**2, -np.inf)

    random = np.random.default_rng(1)
    sampler = emcee.EnsembleSampler(8, 1, log_probability, vectorize=True)
    sampler.random_state = np.random.RandomState(1).get_state()
    sampler.run_mcmc(random.uniform(0.35, 0.45, (8, 1)), 40)
    assert sampler.get_chain(discard=15, flat=True).mean() == pytest.approx(0.4, abs=0.02)
