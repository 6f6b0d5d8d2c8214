"""Elastic response spectra of records and floors."""
from typing import NamedTuple

import numpy as np

from . import _quoin
from .errors import BadInput


class ResponseSpectrum(NamedTuple):
    """Arrays by period (s): Sd, the largest displacement relative to the ground, m; Sv = w Sd, m/s; Sa = w^2 Sd, m/s2."""
    periods: np.ndarray
    Sa: np.ndarray
    Sv: np.ndarray
    Sd: np.ndarray


def response_spectrum(time_or_dt, acceleration, periods=None, damping=0.05):
    """Elastic response spectrum of a motion, as by `quoin spectrum`. time_or_dt: times of the samples, s, increasing, or
    the time between them. acceleration: m/s2, linear between samples. periods: s; default: 200 from 0.02 to 5 s.
    damping: share of critical, from 0 to below 1. Returns a ResponseSpectrum: periods, Sa, Sv, Sd."""
    values = np.asarray(acceleration, dtype=float)
    time = np.asarray(time_or_dt, dtype=float)
    if time.ndim == 0:
        time = time * np.arange(len(values))
    if values.ndim != 1 or time.shape != values.shape:
        raise BadInput(f"response_spectrum: shapes {time.shape} of times and {values.shape} of accelerations; allowed: one "
                       "time each, or the time between samples")
    if not (np.isfinite(time).all() and np.isfinite(values).all()):
        raise BadInput("response_spectrum: a time or an acceleration is not finite; empty cells of monitors.csv are nan, "
                       "and begin with the second row")
    if not (np.diff(time) > 0).all():
        raise BadInput("response_spectrum: times do not increase; allowed: each later than the one before, or a time between "
                       "samples of more than 0")
    asked = None if periods is None else np.atleast_1d(np.asarray(periods, dtype=float)).tolist()
    return ResponseSpectrum(*(np.array(row) for row in _quoin.response_spectrum(time, values, float(damping), asked)))
