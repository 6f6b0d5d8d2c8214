// Cholesky factor of a sparse stiffness matrix, for many right-hand sides.
//
// Multifrontal (Duff and Reid 1983), with dense fronts by BLAS, on one thread: Debian's serial OpenBLAS gives wrong
// numbers when several threads call it at once. The order of unknowns is nested dissection in space (George 1973).
// Planes divide the masonry, and unknowns on a plane are eliminated after those on both sides.
#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <vector>

#include "geometry/vector.h"

namespace quoin {

// Unknowns that are eliminated together: those of a gridpoint or of a rigid block.
struct UnknownGroups {
  std::vector<int> begin;               // begin of each group, and the end of the last, in the order of unknowns
  std::vector<geometry::Vector> place;  // m
  int size() const { return static_cast<int>(place.size()); }
};

class SparseCholesky {
 public:
  // lower: triangle of a symmetric matrix. Throws Error(numerical) for one that is not positive definite.
  SparseCholesky(const Eigen::SparseMatrix<double>& lower, const UnknownGroups& groups);
  void solve(Eigen::MatrixXd& x) const;  // solves for each column of x, in place
  double entries() const;                // number of entries of the factor

 private:
  struct Front {
    int first = 0, own = 0;     // range of its unknowns, in the order of elimination
    std::vector<int> border;    // later unknowns with entries in its columns, ascending
    std::vector<int> children;  // indices of fronts
    Eigen::MatrixXd factor;     // own columns; rows: own, then border
  };

  class Dissection;
  void find_borders(const Eigen::SparseMatrix<double>& permuted);
  void factorize(const Eigen::SparseMatrix<double>& permuted);
  void eliminate(Front& front, Eigen::MatrixXd& full) const;

  std::vector<int> new_of_old_;
  std::vector<Front> fronts_;  // children before parents
};

}  // namespace quoin
