"""Microslip: uncertain friction contacts, and how far they move the resonance of turbine blades.

    study = microslip.Study.read("study.toml")
    results = study.run(output="out", threads=8)          # resumes what was solved before
    table = pyarrow.table(results.samples)

    model = study.model(anchors=64)
    frequency_hz, amplitude_m, status = model(X)          # X: (n, k), in the order of model.input_names
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._native import StudyError

__all__ = ["Model", "Results", "Study", "StudyError", "Table"]

#: Called with samples done and samples in all, from the thread that waits.
Progress = Callable[[int, int], Any]


class Study:
    """A study: what is computed, with which settings, on which samples. Made by :meth:`Study.read`."""

    def __init__(self, native: _native.Study) -> None:
        self._native = native

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Study:
        """Reads and checks a study file.

        Raises :class:`StudyError`, a ``ValueError``, with file, line, key and rule; ``OSError`` if the file cannot be read.
        """
        return cls(_native.Study.read(path))

    def __repr__(self) -> str:
        return f"Study({self.name!r}, {self.samples} samples, inputs {self.input_names}, levels {self.levels})"

    @property
    def name(self) -> str:
        """Name, for reports."""
        return self._native.name

    @property
    def path(self) -> Path:
        """The study file."""
        return Path(self._native.path)

    @property
    def samples(self) -> int:
        """Number of samples, at most."""
        return self._native.samples

    @property
    def levels(self) -> list[float]:
        """Excitation levels, ascending (N for the built-in model)."""
        return self._native.levels

    @property
    def input_names(self) -> list[str]:
        """Names of the random inputs, in the order of their values everywhere."""
        return self._native.input_names

    @property
    def warnings(self) -> list[str]:
        """What may be meant but is unusual, with file, line, key and the usual range."""
        return self._native.warnings

    def run(
        self,
        output: str | os.PathLike[str] | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Results:
        """Solves all samples and writes tables, numbers and report, as the command ``microslip run`` does.

        What is solved is kept in the folder ``output`` (the study's own if absent) on the way, and the same call goes on: after
        Ctrl-C (``KeyboardInterrupt``, once the samples at work are solved), a kill or a failure. The results are the same bits for
        any number of ``threads`` (all cores if absent). Other threads of Python run meanwhile.

        Of a disk the study names one engine order. Warns (``UserWarning``) of :attr:`warnings` and, before anything is solved, where results of
        another study will be replaced; at the end of what else the command warns of.
        """
        for message in [*self.warnings, *self._native.check_folder(output)]:
            warnings.warn(message, stacklevel=2)
        folder, messages = self._native.run(output, threads, progress)
        for message in messages:
            warnings.warn(message, stacklevel=2)
        return Results(folder)

    def model(
        self,
        anchors: int = 64,
        results: Results | str | os.PathLike[str] | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Model:
        """The model as a function of its inputs.

        It first solves the first ``anchors`` samples of the study, 1024 at most and all if it has fewer, from which every search starts; or takes
        them from ``results`` of a run of this study with as many samples, whatever it asks of them, where nothing is solved. With more anchors a point costs less.
        """
        folder = results.path if isinstance(results, Results) else results
        return Model(self, self._native.evaluator(anchors, folder, threads, progress))


class Model:
    """The model of a study: values of the inputs to resonance frequency, amplitude and status at every level.

    Results are the same bits for the same anchors, whatever the number of threads, the other points and their order. They agree
    with the samples of a run to 1e-8 in frequency. Made by :meth:`Study.model`.
    """

    def __init__(self, study: Study, native: _native.Evaluator) -> None:
        self._native = native
        #: Names of the inputs, in the order of the columns.
        self.input_names: list[str] = study.input_names
        #: Excitation levels, ascending.
        self.levels: list[float] = study.levels

    def __repr__(self) -> str:
        return f"Model(inputs {self.input_names}, levels {self.levels}, {self.anchors} anchors)"

    @property
    def anchors(self) -> int:
        """Number of solved samples from which every search starts."""
        return self._native.anchors

    def __call__(self, X: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.str_]]:
        """Resonance frequencies (Hz), amplitudes of the first response (m) and status names.

        ``X`` has the shape (n, k), k values in the order of ``input_names`` in the units of the study file; each result has the shape
        (n, levels). One point of the shape (k,) gives results of the shape (levels,). Where nothing was found the numbers are NaN and
        the status says why; a failed point is no exception.

        A status other than ``converged`` may go with a number (``truncation-above-threshold``, ``unstable``, ``bouncing-contact``): verdicts of a
        run count such samples as unknown.

        Raises :class:`StudyError` with row, input and rule for a value that cannot be meant, before anything is solved.
        """
        points = np.ascontiguousarray(X, dtype=np.float64)
        rows = np.atleast_2d(points)
        wanted = len(self.input_names)
        if points.ndim not in (1, 2) or rows.shape[1] != wanted:
            names = ", ".join(self.input_names)
            raise StudyError(f"X has the shape {points.shape}: must be (n, {wanted}), columns {names}")
        frequency, amplitude, status = self._native.evaluate(rows.tobytes(), len(rows))
        shape = points.shape[:-1] + (len(self.levels),)

        def numbers(data: bytes) -> NDArray[np.float64]:
            return np.frombuffer(data, dtype=np.float64).reshape(shape).copy()

        return numbers(frequency), numbers(amplitude), np.array(status, dtype=np.str_).reshape(shape)

    def scalar(
        self,
        X: ArrayLike,
        output: Literal["amplitude", "frequency"] = "amplitude",
        level: float | None = None,
        missing: Literal["raise"] | float = "raise",
    ) -> NDArray[np.float64]:
        """One number per point, for packages that know no missing values: shape (n,), or () for one point.

        ``output`` is the amplitude (m) or the frequency (Hz) at ``level``, which may be left out where the study has one. A point
        without a resonance raises :class:`StudyError` with its status, or has the value ``missing``. Choose such a value with care: a
        package takes it for a result, and many of them take NaN for zero without a word.
        """
        if output not in ("amplitude", "frequency"):
            raise StudyError(f'output = {output!r}: must be "amplitude" or "frequency"')
        if level is None and len(self.levels) == 1:
            level = self.levels[0]
        if level not in self.levels:
            raise StudyError(f"level = {level!r}: must be a level of the study: {self.levels}")
        place = self.levels.index(level)
        frequency, amplitude, status = self(X)
        values = (amplitude if output == "amplitude" else frequency)[..., place]
        lost = np.isnan(values)
        if missing != "raise":
            return np.where(lost, float(missing), values)
        if lost.any():
            row = int(np.argmax(lost))
            why = str(np.atleast_1d(status[..., place])[row])
            message = f"row {row}: {why} at level {level}: no number"
            raise StudyError(f"{message} ({int(lost.sum())} of {lost.size} rows); missing = VALUE takes that instead")
        return values


class Table:
    """A table of results, for every package that reads streams of Arrow: ``pyarrow.table(table)``, ``polars.DataFrame(table)``,
    ``pandas.DataFrame.from_arrow(table)``, DuckDB by its variable's name. Each reading streams the file anew.
    """

    def __init__(self, path: Path) -> None:
        #: The Parquet file.
        self.path = path

    def __repr__(self) -> str:
        return f"Table({str(self.path)!r})"

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """A stream of record batches (Arrow PyCapsule interface); the requested schema is not looked at, as that allows."""
        return _native.stream(self.path)


class Results:
    """The results of a run, in their folder."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        #: The folder.
        self.path = Path(path)
        if not (self.path / "run.json").is_file():
            raise StudyError(f"{self.path}: holds no results of a run")

    def __repr__(self) -> str:
        return f"Results({str(self.path)!r})"

    @property
    def samples(self) -> Table:
        """One row per sample and level, those without a solution too: inputs, status, frequency (Hz), amplitude (m) and more."""
        return Table(self.path / "samples.parquet")

    @property
    def curves(self) -> Table:
        """One row per point of the forced response curves of the first samples."""
        return Table(self.path / "curves.parquet")

    @property
    def summary(self) -> dict[str, Any]:
        """``summary.json``: all statistics."""
        summary: dict[str, Any] = json.loads((self.path / "summary.json").read_text(encoding="utf-8"))
        return summary

    @property
    def report(self) -> Path:
        """``report.html``, for a browser."""
        return self.path / "report.html"
