"""Quantiles of the distributions against those of OpenTURNS. Usage: against_openturns.py PRINT_RANDOM"""
import math
import subprocess
import sys

import openturns as ot


def of(shape, mean, scatter, lower, upper):
    if shape == "uniform":
        return ot.Uniform(lower, upper)
    parameters = {"normal": lambda: ot.Normal(mean, scatter),
                  "lognormal": lambda: ot.LogNormal(*ot.LogNormalMuSigma(mean, scatter, 0.0).evaluate()),
                  "weibull": lambda: ot.WeibullMin(*ot.WeibullMinMuSigma(mean, scatter, 0.0).evaluate())}
    whole = parameters[shape]()
    if math.isinf(lower) and math.isinf(upper):
        return whole
    if math.isinf(upper):
        return ot.TruncatedDistribution(whole, lower, ot.TruncatedDistribution.LOWER)
    return ot.TruncatedDistribution(whole, lower, upper)


worst = 0.0
rows = subprocess.run([sys.argv[1]], check=True, capture_output=True, text=True).stdout.splitlines()
for row in rows:
    shape, *numbers = row.split()
    mean, scatter, lower, upper, p, quantile, mean_value = map(float, numbers)
    known = of(shape, mean, scatter, lower, upper)
    # OpenTURNS computes quantiles of truncated distributions and parameters of Weibull by iteration, to about 1e-9.
    for what, ours, theirs in [("quantile", quantile, known.computeQuantile(p)[0]), ("mean", mean_value, known.getMean()[0])]:
        error = abs(ours / theirs - 1)
        worst = max(worst, error)
        if not error < 1e-6:
            sys.exit(f"{row}: {what} {ours}, OpenTURNS {theirs}")
if len(rows) != 42:
    sys.exit(f"{len(rows)} rows instead of 42")
print(f"{len(rows)} quantiles and means agree to {worst:.1e}")
