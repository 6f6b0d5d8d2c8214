// Normal variables that go together: with each other, and along a line.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "random/distribution.h"

namespace quoin::random {

// Lower triangle L, row by row, of L L^T = a matrix of correlations (n x n, row by row). L times independent standard
// normal variables has these correlations. Empty: there are no such variables (the matrix is not positive definite).
std::vector<double> mix_of(const std::vector<double>& correlations, std::size_t n);

// Two values in the order of a line at a distance (m, >= 0), correlated by exp(-distance/length). The second is a share
// of the first and a share of what is new, whose squares add up to 1. For a length of 0 all of it is new, but at the
// same place.
struct Follow {
  double share, fresh;
};
Follow follow(double distance, double length);

// Variance of the mean over an interval (m) of a field so correlated, over that of a point. It is Vanmarcke's variance
// function, 2 (L/T)^2 (T/L - 1 + exp(-T/L)).
double variance_of_mean(double interval, double length);

// The distribution of points of one field whose mean over these places x (m), with these weights (sum 1), is `of_mean`.
// It has the same mean and shape, and a larger scatter. Normal and lognormal without bounds only.
Distribution of_points(const Distribution& of_mean, double length, std::span<const double> x,
                       std::span<const double> weight);

}  // namespace quoin::random
