// Cholesky factors of sparse stiffness matrices, for many solutions with one matrix.
//
// Multifrontal (Duff and Reid 1983), with dense fronts by BLAS. Unknowns are ordered by nested dissection in space
// (George 1973): masonry is cut along planes, and what lies on a cut is eliminated after both sides of it.
#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "base/thread_pool.h"
#include "geometry/vector.h"
#include "model/lanes.h"

namespace quoin {

// Unknowns that are eliminated together: those of a gridpoint or a rigid block.
struct UnknownGroups {
  std::vector<int> begin;               // of each group, and the end of the last; in the order of unknowns
  std::vector<geometry::Vector> place;  // m
  int size() const { return static_cast<int>(place.size()); }
};

class SparseCholesky {
 public:
  // lower: triangle of a symmetric matrix. threads 0: as many as the machine has; the bits do not depend on them.
  // Throws Error(numerical) where the matrix is not positive definite.
  SparseCholesky(const Eigen::SparseMatrix<double>& lower, const UnknownGroups& groups, int threads = 0);
  void solve(Eigen::MatrixXd& x) const;  // columns, in place
  double entries() const { return static_cast<double>(factor_.size()); }

 private:
  struct Front {
    int first = 0, own = 0;     // of its unknowns, in the order of elimination
    std::vector<int> border;    // later unknowns that it touches, ascending
    std::vector<int> children;  // fronts
    std::size_t at = 0;         // in factor_: own columns; rows: own, then border
    int size() const { return own + static_cast<int>(border.size()); }
  };
  // What a thread needs besides.
  struct Scratch {
    std::vector<double> full;
    std::vector<int> place;  // of unknowns in the front of now
  };

  class Dissection;
  void find_borders(const Eigen::SparseMatrix<double>& permuted);
  void divide();
  template <class Visit>
  void each_front(bool upwards, const Visit& visit) const;
  void factorize(const Eigen::SparseMatrix<double>& permuted);
  void form(int front, const Eigen::SparseMatrix<double>& permuted, std::vector<Eigen::MatrixXd>& update,
            Scratch& scratch);
  void eliminate(const Front& front, std::vector<double>& full) const;
  void forward(int front, Eigen::MatrixXd& x, std::vector<Eigen::MatrixXd>& update) const;
  void backward(int front, Eigen::MatrixXd& x, Eigen::MatrixXd& part) const;

  std::vector<int> new_of_old_;
  std::vector<Front> fronts_;  // children before parents
  LaneVector<double> factor_;
  // Ranges of fronts that are independent of each other, and the fronts above them.
  std::vector<std::array<int, 2>> subtrees_;
  std::vector<int> top_;
  std::unique_ptr<ThreadPool> pool_;
};

}  // namespace quoin
