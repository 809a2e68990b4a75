import os
from collections.abc import Callable
from typing import Any

class StudyError(ValueError):
    """What a study, a file or a value breaks: the message has file, line or key, and the rule."""

class Study:
    @staticmethod
    def read(path: str | os.PathLike[str]) -> Study: ...
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> os.PathLike[str]: ...
    @property
    def samples(self) -> int: ...
    @property
    def levels(self) -> list[float]: ...
    @property
    def input_names(self) -> list[str]: ...
    @property
    def warnings(self) -> list[str]: ...
    def run(
        self,
        output: str | os.PathLike[str] | None,
        threads: int | None,
        progress: Callable[[int, int], Any] | None,
    ) -> os.PathLike[str]: ...
    def evaluator(
        self,
        anchors: int,
        results: str | os.PathLike[str] | None,
        threads: int | None,
        progress: Callable[[int, int], Any] | None,
    ) -> Evaluator: ...

class Evaluator:
    @property
    def anchors(self) -> int: ...
    def evaluate(self, points: bytes, columns: int) -> tuple[bytes, bytes, list[str]]: ...

def stream(path: str | os.PathLike[str]) -> object: ...
