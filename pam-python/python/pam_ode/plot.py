"""Figures with matplotlib: those of the reports."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ._arrays import Array

if TYPE_CHECKING:
    from .control import Plan
    from .diagnosis import Diagnosis
    from .model import Model, Prediction
    from .recording import Recording
    from .training import Training

__all__ = ["diagnosis", "force_curves", "plan", "prediction", "recording", "training", "trajectory"]

_LABELS = ("x (mm)", "v (mm/s)", "P_f (kPa)", "P_e (kPa)")
_MEASURED, _PREDICTED, _AFTER = "0.35", "tab:blue", "tab:orange"


def _axes(axes: Any, rows: int, columns: int = 1, **options: Any) -> Any:
    if axes is not None:
        return axes
    plt = importlib.import_module("matplotlib.pyplot")
    width, height = 8.0 if columns == 1 else 4.0 * columns, 1.8 * rows if columns == 1 else 3.2 * rows
    _, found = plt.subplots(rows, columns, figsize=(width, height), layout="constrained", **options)
    return found


def recording(recording: Recording, axes: Any = None) -> Any:
    """All channels of a recording over time; returns the five axes."""
    axes = _axes(axes, 5, sharex=True)
    columns = (
        ("F_e (N)", recording.force_n),
        *zip(_LABELS, recording.states.T),
    )
    for ax, (label, values) in zip(axes, columns):
        ax.plot(recording.time_s, values, color=_MEASURED, lw=0.8)
        ax.set_ylabel(label)
    axes[-1].set_xlabel("time (s)")
    axes[0].set_title(recording.name)
    return axes


def trajectory(recording: Recording, states: Array, axes: Any = None) -> Any:
    """Measured and predicted channels over time; returns the four axes."""
    axes = _axes(axes, 4, sharex=True)
    for ax, label, measured, predicted in zip(axes, _LABELS, recording.states.T, states.T):
        ax.plot(recording.time_s, measured, color=_MEASURED, lw=0.8, label="measured")
        ax.plot(recording.time_s[: len(predicted)], predicted, color=_PREDICTED, lw=0.8, label="predicted")
        ax.set_ylabel(label)
    axes[-1].set_xlabel("time (s)")
    axes[0].set_title(recording.name)
    axes[0].legend(loc="upper right")
    return axes


def prediction(prediction: Prediction, axes: Any = None) -> Any:
    """Measured and predicted channels of a prediction over time; returns the four axes."""
    return trajectory(prediction.recording, prediction.states, axes)


def training(training: Training, axes: Any = None) -> Any:
    """The loss over the epochs, stage by stage; returns the axes."""
    ax = _axes(axes, 1)
    for k, stage in enumerate(dict.fromkeys(e.stage_name for e in training.epochs)):
        rows = [e for e in training.epochs if e.stage_name == stage]
        ax.semilogy([e.total_epoch for e in rows], [e.loss for e in rows], color=f"C{k}", label=stage)
    ax.set_xlabel("epoch")
    ax.set_ylabel("loss")
    ax.legend()
    return ax


def diagnosis(diagnosis: Diagnosis, axes: Any = None, index: int = 0) -> Any:
    """Loop (force over displacement) and motion of a test recording: measured, before and after; returns two axes."""
    axes = _axes(axes, 1, 2)
    trace = diagnosis.traces()[index]
    channel = next(iter(trace.measured))
    for label, color, values in (
        ("measured", _MEASURED, trace.measured[channel]),
        ("before", _PREDICTED, trace.before[channel]),
        ("after", _AFTER, trace.after[channel]),
    ):
        axes[0].plot(values, trace.excitation[: len(values)], color=color, lw=0.8, label=label)
        axes[1].plot(trace.time_s[: len(values)], values, color=color, lw=0.8, label=label)
    axes[0].set(xlabel="x (mm)", ylabel="F_e (N)", title=trace.name)
    axes[1].set(xlabel="time (s)", ylabel="x (mm)")
    axes[1].legend(loc="upper right")
    return axes


def plan(plan: Plan, axes: Any = None) -> Any:
    """Motion, stiffness and pressures of a plan over time; returns the three axes."""
    axes = _axes(axes, 3, sharex=True)
    axes[0].plot(plan.time_s, plan.displacement_mm, color=_PREDICTED)
    axes[0].set_ylabel("x (mm)")
    axes[1].plot(plan.time_s, plan.wanted_stiffness_n_mm, color=_MEASURED, ls="--", label="wanted")
    axes[1].plot(plan.time_s, plan.stiffness_n_mm, color=_PREDICTED, label="planned")
    axes[1].set_ylabel("K (N/mm)")
    axes[1].legend(loc="upper right")
    for k, name in enumerate(("flexor", "extensor")):
        axes[2].plot(plan.time_s, plan.pressures_kpa[:, k], color=f"C{k}", label=name)
    axes[2].set(xlabel="time (s)", ylabel="P (kPa abs)")
    axes[2].legend(loc="upper right")
    return axes


def force_curves(model: Model, pressures_kpa: Any = (170.27, 411.59, 652.91), reach_mm: float = 3.0, axes: Any = None) -> Any:
    """Restoring force and stiffness over the displacement at pressures (kPa absolute) in both muscles; returns two axes."""
    import numpy as np

    axes = _axes(axes, 1, 2)
    x = np.linspace(-reach_mm, reach_mm, 241)
    for kpa in pressures_kpa:
        found = model.linearise(x, pressures_kpa=kpa)
        axes[0].plot(x, found.force_n, label=f"{kpa:.0f} kPa")
        axes[1].plot(x, found.stiffness_n_mm, label=f"{kpa:.0f} kPa")
    axes[0].set(xlabel="x (mm)", ylabel="f (N)")
    axes[1].set(xlabel="x (mm)", ylabel="K (N/mm)")
    axes[0].legend()
    return axes
