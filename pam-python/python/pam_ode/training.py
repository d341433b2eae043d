"""Training."""

from __future__ import annotations

import json
import os
import tempfile
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Sequence, Union

import numpy as np

from . import _pam
from ._arrays import Array
from ._html import table
from ._options import Changes, Path, changes, optional_path
from ._progress import Progress, shown
from .gradients import Loss, native_loss
from .model import Model
from .recording import Recording, natives

__all__ = ["Epoch", "Stage", "Training", "train"]


@dataclass(frozen=True)
class Epoch:
    """One epoch in numbers."""

    #: Index and name of the stage.
    stage: int
    stage_name: str
    #: Epoch of the stage and of the whole training, from one.
    epoch: int
    total_epoch: int
    #: The loss, regularisers included.
    loss: float
    #: The learning rate.
    rate: float
    #: R² of x, v, P_f, P_e of the recordings held out, where they were scored.
    r2_held_out: tuple[float | None, ...] | None
    #: Everything of the row of ``metrics.csv``.
    row: dict[str, Any]


@dataclass(frozen=True)
class Stage:
    """The result of a finished stage."""

    name: str
    epochs: int
    seconds: float
    first_loss: float | None
    best_loss: float
    #: Mean R² of x, v, P_f, P_e over its recordings, and over those held out.
    r2_train: tuple[float | None, ...]
    r2_held_out: tuple[float | None, ...]


@dataclass(frozen=True)
class Training:
    """The result of a training."""

    #: The trained model.
    model: Model
    #: Whether all stages were done.
    finished: bool
    stages: tuple[Stage, ...]
    epochs: tuple[Epoch, ...]
    #: Messages for the reader.
    events: tuple[str, ...]

    @property
    def losses(self) -> Array:
        """The loss of each epoch."""
        return np.array([e.loss for e in self.epochs])

    def __repr__(self) -> str:
        return f"Training({len(self.stages)} stages, {len(self.epochs)} epochs, finished: {self.finished})"

    def _repr_html_(self) -> str:
        rows = [(s.name, s.epochs, s.seconds, s.best_loss, s.r2_train[0], s.r2_held_out[0]) for s in self.stages]
        head = ["stage", "epochs", "time (s)", "best loss", "R² of x, trained on", "R² of x, held out"]
        return table(head, rows, repr(self))

    def plot(self, axes: Any = None) -> Any:
        """Draws the loss over the epochs with matplotlib; see :func:`pam_ode.plot.training`."""
        from . import plot

        return plot.training(self, axes=axes)


def _epoch(row: dict[str, Any], names: Sequence[str] = ()) -> Epoch:
    held_out = row.get("r2_held_out")
    return Epoch(
        row["stage"],
        row.get("stage_name") or names[row["stage"]],
        row["epoch"],
        row["total_epoch"],
        row["loss"],
        row["rate"],
        None if held_out is None else tuple(held_out),
        row,
    )


def train(
    recordings: Sequence[Recording],
    curriculum: Union[str, Path, Mapping[str, Any]] = "recommended",
    *,
    held_out: Sequence[Recording] = (),
    settings: Changes | None = None,
    start: Model | None = None,
    loss: Loss | None = None,
    surfaces: Path | None = None,
    seed: int = 1,
    folder: Path | None = None,
    name: str | None = None,
    callback: Callable[[Epoch], Any] | None = None,
    progress: Progress = False,
) -> Training:
    """Trains a model on recordings.

    Args:
        recordings: Recordings to train on.
        curriculum: A built-in name (``recommended``, ``paper``, …), a TOML file, or a dict: a whole curriculum with
            ``stage``, or changes of ``recommended``.
        held_out: Recordings to score on and never train on.
        settings: Changes of the curriculum, like ``{"rate": 3e-4, "stage.2.epochs": 50, "model.hidden": [32, 32]}``; stages
            count from zero.
        start: The model to start from, in place of random weights. Its effects are trained along.
        loss: A loss in place of the curriculum's; see :data:`pam_ode.gradients.Loss`.
        surfaces: File of single-muscle surfaces, which give masses as long as the model is untrained.
        seed: Seed of weights and batches. The same seed gives the same model at any number of threads.
        folder: Folder of the run, with checkpoints; a run that was begun there goes on.
        name: Name of the model.
        callback: Called after every epoch; ``False`` as its result stops the training.
        progress: ``True`` for a bar, or a function of (what, share, text).

    Raises:
        SettingsError: A setting makes no sense.
        TrainingError: With ``stage`` and ``epoch``.
    """
    told = dict(settings or {})
    if isinstance(curriculum, Mapping):
        if "stage" in curriculum:
            text = json.dumps(curriculum)
        else:
            text, told = "recommended", {**curriculum, **told}
    else:
        text = os.fspath(curriculum)
    with tempfile.TemporaryDirectory(prefix="pam-") as temporary, shown(progress) as function:
        if start is not None:
            path = os.path.join(temporary if folder is None else os.fspath(folder), "start.safetensors")
            os.makedirs(os.path.dirname(path), exist_ok=True)
            start.save(path)
            told["model.start"] = {"file": path}
        names: list[str] = []

        def after(row: str) -> bool:
            assert callback is not None
            return callback(_epoch(json.loads(row))) is not False

        native, course = _pam.train(
            natives(recordings),
            natives(held_out),
            text,
            changes=changes(told),
            loss=None if loss is None else native_loss(loss),
            surfaces=optional_path(surfaces),
            seed=seed,
            folder=optional_path(folder),
            name=name,
            callback=None if callback is None else after,
            progress=function,
        )
    data = json.loads(course)
    names = data["stage_names"]
    stages = tuple(
        Stage(
            s["name"],
            s["epochs"],
            s["seconds"],
            s["first_loss"],
            s["best_loss"],
            tuple(s["r2_train"]),
            tuple(s["r2_held_out"]),
        )
        for s in data["stages"]
    )
    epochs = tuple(_epoch(row, names) for row in data["epochs"])
    return Training(Model._of(native), data["finished"], stages, epochs, tuple(data["events"]))
