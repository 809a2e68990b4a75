"""Studies, runs and their tables."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import microslip
import pytest
from conftest import write_study


def test_a_study_says_what_it_is(study: microslip.Study) -> None:
    """Seen to fail with the levels in descending order."""
    assert study.name == "Own matrices"
    assert study.input_names == ["stiffness_scale", "friction_coefficient"]
    assert study.levels == [1.0, 20.0]
    assert study.samples == 12
    assert study.path.name == "study.toml"
    assert study.warnings == []
    assert "12 samples" in repr(study)


def test_a_mistake_is_named_with_file_line_and_key(tmp_path: Path) -> None:
    """Seen to fail with a plain RuntimeError for the errors of the engine."""
    path = write_study(tmp_path, ("low = 0.2", "low = -0.2"))
    with pytest.raises(ValueError, match=r"study\.toml:\d+: inputs\.friction_coefficient") as raised:
        microslip.Study.read(path)
    assert type(raised.value) is microslip.StudyError
    with pytest.raises(OSError, match="absent.toml"):
        microslip.Study.read(tmp_path / "absent.toml")


def test_a_run_has_tables_numbers_and_a_report(results: microslip.Results) -> None:
    """Seen to fail with an empty summary."""
    assert results.summary["provenance"]["study"] == "Own matrices"
    assert results.report.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert microslip.Results(results.path).summary == results.summary
    assert len(results.summary["levels"]) == 2
    with pytest.raises(microslip.StudyError, match="no results of a run"):
        microslip.Results(results.path.parent / "absent")


def test_results_of_another_study_are_not_replaced_without_a_warning(tmp_path: Path) -> None:
    """Seen to fail with the package before, which said nothing."""
    study = microslip.Study.read(write_study(tmp_path))
    folder = tmp_path / "results"
    study.run(output=folder)
    before = (folder / "samples.parquet").read_bytes()
    other = microslip.Study.read(write_study(tmp_path, ("low = 0.2", "low = 0.25")))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # nothing is solved where the warning is an error
        with pytest.raises(UserWarning, match="replaces the results in .*, of another study"):
            other.run(output=folder)
        assert (folder / "samples.parquet").read_bytes() == before
    with pytest.warns(UserWarning, match="replaces the results in .*, of another study"):
        other.run(output=folder)
    assert (folder / "samples.parquet").read_bytes() != before


def test_what_is_unusual_in_a_study_is_a_warning_of_its_run(tmp_path: Path) -> None:
    """Seen to fail with the package before, which said so in ``Study.warnings`` alone."""
    study = microslip.Study.read(write_study(tmp_path, ("mu = 0.4", "mu = 4.0")))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="is unusual"):
            study.run(output=tmp_path / "results")


def test_a_model_takes_results_that_were_asked_other_things(results: microslip.Results, tmp_path: Path) -> None:
    """Seen to fail with the package before, which refused them as those of another study."""
    study = microslip.Study.read(write_study(tmp_path, ("limit = 3.0", "limit = 4.0")))
    assert study.model(anchors=4, results=results).anchors == 4
    other = microslip.Study.read(write_study(tmp_path, ("low = 0.2", "low = 0.25")))
    with pytest.raises(microslip.StudyError, match="of another study"):
        other.model(anchors=4, results=results)


def test_progress_is_told_and_may_end_a_run(study: microslip.Study, tmp_path: Path) -> None:
    """Seen to fail with progress that is told at the end alone."""
    told: list[tuple[int, int]] = []
    study.run(output=tmp_path / "told", threads=1, progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (12, 12) and len(told) > 2

    def fails(done: int, total: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        study.run(output=tmp_path / "ended", threads=1, progress=fails)
    assert not (tmp_path / "ended" / "samples.parquet").exists()
    with pytest.raises(microslip.StudyError, match="threads = 0"):
        study.run(output=tmp_path / "none", threads=0)


def test_other_threads_run_meanwhile(study: microslip.Study, tmp_path: Path) -> None:
    """Seen to fail with the interpreter's lock held."""
    ticks: list[float] = []
    ended = threading.Event()

    def tick() -> None:
        while not ended.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.monotonic()
    study.run(output=tmp_path / "run", threads=1)
    took = time.monotonic() - begun
    ended.set()
    thread.join()
    assert len(ticks) > 20 * took, f"{len(ticks)} ticks in {took} s"


RUN = """
import microslip, sys
print("begun", flush=True)
try:
    microslip.Study.read(sys.argv[1]).run(output=sys.argv[2], threads=1, progress=lambda *told: print(*told, flush=True))
except KeyboardInterrupt as interrupt:
    print("interrupted", flush=True)
    sys.exit(7)
"""


def test_ctrl_c_leaves_a_folder_that_resumes(tmp_path: Path) -> None:
    """Seen to fail with signals that nobody looks at: the run then goes to its end."""
    path = write_study(tmp_path / "study", ("samples = 12", "samples = 400"))
    arguments = [sys.executable, "-c", RUN, str(path), str(tmp_path / "out")]
    child = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    for line in child.stdout:
        if line[0].isdigit() and int(line.split()[0]) > 3:
            break
    os.kill(child.pid, signal.SIGINT)
    rest = child.stdout.read()
    assert child.wait(timeout=60) == 7, rest
    assert rest.endswith("interrupted\n")
    kept = list((tmp_path / "out" / "parts").glob("*.samples.parquet"))
    assert kept and not (tmp_path / "out" / "samples.parquet").exists()
    study = microslip.Study.read(path)
    told: list[int] = []
    resumed = study.run(output=tmp_path / "out", progress=lambda done, total: told.append(done))
    assert told[0] > 3, "nothing was taken over"
    whole = study.run(output=tmp_path / "whole")
    tables = [(run.path / "samples.parquet").read_bytes() for run in (resumed, whole)]
    assert tables[0] == tables[1]


def test_tables_are_read_by_arrow_consumers(results: microslip.Results) -> None:
    """Each reads all rows with their types. Seen to fail with a capsule of another name, and with a stream that is used up."""
    duckdb = pytest.importorskip("duckdb")
    pandas = pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    pyarrow = pytest.importorskip("pyarrow")
    pyarrow_parquet = pytest.importorskip("pyarrow.parquet")
    samples = results.samples
    table = pyarrow.table(samples)
    assert table.num_rows == 12 * 2
    expected = pyarrow_parquet.read_table(results.path / "samples.parquet")
    assert table.to_pydict() == expected.to_pydict()
    frame = polars.DataFrame(results.samples)
    assert frame["frequency_hz"].to_list() == table["frequency_hz"].to_pylist()
    if hasattr(pandas.DataFrame, "from_arrow"):
        assert len(pandas.DataFrame.from_arrow(results.samples)) == 24
    assert table.to_pandas()["level"].tolist()[:2] == [1.0, 20.0]
    [found] = duckdb.sql("select count(*), sum(friction_coefficient) from samples").fetchall()
    assert found[0] == 24
    assert found[1] == pytest.approx(sum(table["friction_coefficient"].to_pylist()))
    curves = pyarrow.table(results.curves)
    assert set(curves["sample"].to_pylist()) == {0, 1}


def test_a_damaged_table_is_an_error(results: microslip.Results, tmp_path: Path) -> None:
    """Seen to fail with another exception for the errors of the Parquet library."""
    path = tmp_path / "samples.parquet"
    path.write_bytes(b"PAR1" + b"x" * 100)
    pyarrow = pytest.importorskip("pyarrow")
    with pytest.raises(microslip.StudyError, match="samples.parquet"):
        pyarrow.table(microslip.Table(path))
    with pytest.raises(OSError):
        pyarrow.table(microslip.Table(tmp_path / "absent.parquet"))
