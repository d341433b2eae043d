"""Hybrid neural ODEs of a joint moved by an antagonistic pair of pneumatic artificial muscles.

    import pam_ode as pam

    model = pam.load()                                   # a trained model; or a file
    recordings = pam.read("logs")                        # raw logs, CSV, .npz, .mat
    prediction = model.predict(recordings[0])            # states [samples, 4]
    value, gradient = pam.value_and_gradient(model, recordings)

Units are s, mm, mm/s, kPa absolute, g, N; a force of the network itself is in mN. ``pam_ode.jax`` and ``pam_ode.torch`` put
losses and simulations into JAX and PyTorch; they are imported on their own.
"""

from __future__ import annotations

from . import errors
from ._pam import __version__, names
from .comparison import Comparison, ModelScore, compare, comparison_example
from .control import Plan, PlanSummary, plan
from .diagnosis import Diagnosis, diagnose
from .effects import ActiveEffect, EffectInfo, define_effects, effect, effects, hidden_effects
from .errors import (
    ComparisonError,
    ControlError,
    DataError,
    DiagnoseError,
    EffectError,
    ModelError,
    PamError,
    PamWarning,
    RigError,
    SettingsError,
    SolveError,
    TrainingError,
)
from .evaluation import Evaluation
from .gradients import Gradient, Problem, simulate, value_and_gradient
from .model import Linearisation, Model, PhysicalParameters, Prediction, load
from .recording import COLUMNS, Recording, read
from .rig import Rig, Samples, record
from .training import Epoch, Training, train

__all__ = [
    "COLUMNS",
    "ActiveEffect",
    "Comparison",
    "ComparisonError",
    "ControlError",
    "DataError",
    "Diagnosis",
    "DiagnoseError",
    "EffectError",
    "EffectInfo",
    "Epoch",
    "Evaluation",
    "Gradient",
    "Linearisation",
    "Model",
    "ModelError",
    "ModelScore",
    "PamError",
    "PamWarning",
    "PhysicalParameters",
    "Plan",
    "PlanSummary",
    "Prediction",
    "Problem",
    "Recording",
    "Rig",
    "RigError",
    "Samples",
    "SettingsError",
    "SolveError",
    "Training",
    "TrainingError",
    "__version__",
    "compare",
    "comparison_example",
    "define_effects",
    "diagnose",
    "effect",
    "effects",
    "errors",
    "hidden_effects",
    "load",
    "names",
    "plan",
    "read",
    "record",
    "simulate",
    "train",
    "value_and_gradient",
]
