#include "sparse/sparse_cholesky.h"

#include <cblas.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "base/index.h"

// Cholesky factor of LAPACK, in OpenBLAS.
extern "C" void dpotrf_(const char* triangle, const int* n, double* a, const int* lda, int* info);

namespace quoin {
namespace {

using Eigen::MatrixXd;
using geometry::Vector;
using Matrix = Eigen::SparseMatrix<double>;

// Largest number of unknowns of a part that is not divided further. A front of that size is fast, and smaller ones are
// mostly overhead.
constexpr int kLeaf = 200;

// Graph of groups that share an entry of the matrix, in rows.
struct Graph {
  std::vector<int> begin, neighbour;
};

Graph graph_of(const Matrix& lower, const UnknownGroups& groups) {
  std::vector<int> group_of(at(static_cast<int>(lower.rows())));
  for (int g = 0; g < groups.size(); ++g)
    std::fill(group_of.begin() + groups.begin[at(g)], group_of.begin() + groups.begin[at(g) + 1], g);
  std::vector<std::pair<int, int>> edges;
  std::vector<int> touched;
  for (int g = 0; g < groups.size(); ++g) {
    touched.clear();
    for (int column = groups.begin[at(g)]; column < groups.begin[at(g) + 1]; ++column) {
      for (Matrix::InnerIterator entry(lower, column); entry; ++entry)
        touched.push_back(group_of[static_cast<std::size_t>(entry.row())]);
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (const int other : touched) {
      if (other != g) edges.emplace_back(g, other);
    }
  }
  Graph graph;
  graph.begin.assign(at(groups.size()) + 1, 0);
  for (const auto& [a, b] : edges) ++graph.begin[at(a) + 1], ++graph.begin[at(b) + 1];
  std::partial_sum(graph.begin.begin(), graph.begin.end(), graph.begin.begin());
  graph.neighbour.resize(2 * edges.size());
  std::vector<int> next(graph.begin.begin(), graph.begin.end() - 1);
  for (const auto& [a, b] : edges) {
    graph.neighbour[at(next[at(a)]++)] = b;
    graph.neighbour[at(next[at(b)]++)] = a;
  }
  return graph;
}

}  // namespace

// Nested dissection: divides the masonry in two recursively, and numbers the unknowns of each part before those of the
// separator.
class SparseCholesky::Dissection {
 public:
  Dissection(const Matrix& lower, const UnknownGroups& groups)
      : groups_(groups), graph_(graph_of(lower, groups)), part_of_(at(groups.size()), -1) {
    new_of_old.resize(at(static_cast<int>(lower.rows())));
    std::vector<int> all(at(groups.size()));
    std::iota(all.begin(), all.end(), 0);
    cut(std::move(all));
  }
  std::vector<int> new_of_old;
  std::vector<Front> fronts;

 private:
  // Returns the fronts of the part that have no parent yet.
  std::vector<int> cut(std::vector<int> part) {
    std::vector<int> low, high;
    int unknowns = 0;
    for (const int g : part) unknowns += groups_.begin[at(g) + 1] - groups_.begin[at(g)];
    if (unknowns <= kLeaf || !halve(part, low, high)) return {add(part, {})};
    const std::vector<int> border = take_border(low, high);
    part = {};
    std::vector<int> children;
    for (std::vector<int>* side : {&low, &high}) {
      if (side->empty()) continue;
      const std::vector<int> below = cut(std::move(*side));
      children.insert(children.end(), below.begin(), below.end());
    }
    return border.empty() ? children : std::vector<int>{add(border, std::move(children))};
  }

  // Divides the part along its longest axis, at the gap between places that is nearest to the middle of the list.
  bool halve(std::vector<int>& part, std::vector<int>& low, std::vector<int>& high) const {
    Vector least = groups_.place[at(part[0])], most = least;
    for (const int g : part) least = min(least, groups_.place[at(g)]), most = max(most, groups_.place[at(g)]);
    const Vector extent = most - least;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
    const double gap = 1e-7 * extent[axis];
    const auto place = [&](int g) { return groups_.place[at(g)][axis]; };
    std::sort(part.begin(), part.end(),
              [&](int a, int b) { return place(a) != place(b) ? place(a) < place(b) : a < b; });
    const auto count = static_cast<int>(part.size());
    for (int way = 0; way < count; ++way) {
      const int i = count / 2 + (way % 2 == 0 ? way / 2 : -(way + 1) / 2);
      if (i <= 0 || i >= count || !(place(part[at(i)]) - place(part[at(i) - 1]) > gap)) continue;
      low.assign(part.begin(), part.begin() + i), high.assign(part.begin() + i, part.end());
      return true;
    }
    return false;
  }

  // Separator: groups of one side that touch the other, on the side where they have fewer unknowns. Removes them from
  // that side.
  std::vector<int> take_border(std::vector<int>& low, std::vector<int>& high) {
    for (const int g : low) part_of_[at(g)] = 2 * cuts_;
    for (const int g : high) part_of_[at(g)] = 2 * cuts_ + 1;
    const auto touches = [&](int g, int part) {
      for (int k = graph_.begin[at(g)]; k < graph_.begin[at(g) + 1]; ++k) {
        if (part_of_[at(graph_.neighbour[at(k)])] == part) return true;
      }
      return false;
    };
    const auto border_of = [&](const std::vector<int>& side, int other) {
      std::vector<int> border;
      for (const int g : side) {
        if (touches(g, other)) border.push_back(g);
      }
      return border;
    };
    std::vector<int> of_low = border_of(low, 2 * cuts_ + 1), of_high = border_of(high, 2 * cuts_);
    ++cuts_;
    const bool from_low = of_low.size() <= of_high.size();
    std::vector<int>& border = from_low ? of_low : of_high;
    for (const int g : border) part_of_[at(g)] = -1;
    std::erase_if(from_low ? low : high, [&](int g) { return part_of_[at(g)] < 0; });
    return std::move(border);
  }

  int add(const std::vector<int>& part, std::vector<int> children) {
    Front& front = fronts.emplace_back();
    front.first = numbered_, front.children = std::move(children);
    for (const int g : part) {
      for (int i = groups_.begin[at(g)]; i < groups_.begin[at(g) + 1]; ++i) new_of_old[at(i)] = numbered_++;
    }
    front.own = numbered_ - front.first;
    return static_cast<int>(fronts.size()) - 1;
  }

  const UnknownGroups& groups_;
  Graph graph_;
  std::vector<int> part_of_;
  int cuts_ = 0, numbered_ = 0;
};

SparseCholesky::SparseCholesky(const Matrix& lower, const UnknownGroups& groups) {
  {
    Dissection dissection(lower, groups);
    new_of_old_ = std::move(dissection.new_of_old), fronts_ = std::move(dissection.fronts);
  }
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order(
      Eigen::Map<const Eigen::VectorXi>(new_of_old_.data(), lower.rows()));
  Matrix permuted(lower.rows(), lower.cols());
  permuted.selfadjointView<Eigen::Lower>() = lower.selfadjointView<Eigen::Lower>().twistedBy(order);
  find_borders(permuted);
  factorize(permuted);
}

void SparseCholesky::find_borders(const Matrix& permuted) {
  for (Front& front : fronts_) {
    std::vector<int>& border = front.border;
    const int end = front.first + front.own;
    for (int column = front.first; column < end; ++column) {
      for (Matrix::InnerIterator entry(permuted, column); entry; ++entry) {
        if (entry.row() >= end) border.push_back(static_cast<int>(entry.row()));
      }
    }
    for (const int child : front.children) {
      for (const int row : fronts_[at(child)].border) {
        if (row >= end) border.push_back(row);
      }
    }
    std::sort(border.begin(), border.end());
    border.erase(std::unique(border.begin(), border.end()), border.end());
  }
}

void SparseCholesky::factorize(const Matrix& permuted) {
  std::vector<MatrixXd> update(fronts_.size());  // update of a front to its parent, lower triangle
  std::vector<int> place(new_of_old_.size());    // index of unknowns in the current front
  for (std::size_t k = 0; k < fronts_.size(); ++k) {
    Front& front = fronts_[k];
    const int size = front.own + static_cast<int>(front.border.size());
    for (int i = 0; i < front.own; ++i) place[at(front.first + i)] = i;
    for (int i = front.own; i < size; ++i) place[at(front.border[at(i - front.own)])] = i;
    MatrixXd full = MatrixXd::Zero(size, size);
    for (int column = 0; column < front.own; ++column) {
      for (Matrix::InnerIterator entry(permuted, front.first + column); entry; ++entry) {
        const int i = place[at(static_cast<int>(entry.row()))];
        full(std::max(i, column), std::min(i, column)) += entry.value();
      }
    }
    for (const int child : front.children) {
      const std::vector<int>& rows = fronts_[at(child)].border;
      MatrixXd& from = update[at(child)];
      for (std::size_t j = 0; j < rows.size(); ++j) {
        double* const column = &full(0, place[at(rows[j])]);
        const double* const given = &from(0, static_cast<Eigen::Index>(j));
        for (std::size_t i = j; i < rows.size(); ++i) column[place[at(rows[i])]] += given[i];
      }
      from.resize(0, 0);
    }
    eliminate(front, full);
    const auto border = static_cast<Eigen::Index>(front.border.size());
    front.factor = full.leftCols(front.own);
    update[k] = full.bottomRightCorner(border, border);
  }
}

void SparseCholesky::eliminate(Front& front, MatrixXd& full) const {
  const int own = front.own, border = static_cast<int>(front.border.size()), size = own + border;
  int info = 0;
  dpotrf_("L", &own, full.data(), &size, &info);
  if (info != 0) throw Error(Exit::numerical, "a stiffness matrix is not positive definite");
  if (border == 0) return;
  cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, border, own, 1.0, full.data(), size,
              full.data() + own, size);
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, border, own, -1.0, full.data() + own, size, 1.0,
              full.data() + std::ptrdiff_t{own} * size + own, size);
}

void SparseCholesky::solve(MatrixXd& x) const {
  const auto columns = static_cast<int>(x.cols());
  MatrixXd ordered(x.rows(), x.cols());
  for (int c = 0; c < columns; ++c) {
    for (std::size_t i = 0; i < new_of_old_.size(); ++i)
      ordered(new_of_old_[i], c) = x(static_cast<Eigen::Index>(i), c);
  }
  const auto n = static_cast<int>(x.rows());
  MatrixXd part;
  for (const Front& front : fronts_) {
    const int own = front.own, border = static_cast<int>(front.border.size()), size = own + border;
    double* const mine = ordered.data() + front.first;
    cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, own, columns, 1.0,
                front.factor.data(), size, mine, n);
    if (border == 0) continue;
    part.resize(border, columns);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, border, columns, own, 1.0, front.factor.data() + own, size,
                mine, n, 0.0, part.data(), border);
    for (int c = 0; c < columns; ++c) {
      for (int i = 0; i < border; ++i) ordered(front.border[at(i)], c) -= part(i, c);
    }
  }
  for (auto front = fronts_.rbegin(); front != fronts_.rend(); ++front) {
    const int own = front->own, border = static_cast<int>(front->border.size()), size = own + border;
    double* const mine = ordered.data() + front->first;
    if (border > 0) {
      part.resize(border, columns);
      for (int c = 0; c < columns; ++c) {
        for (int i = 0; i < border; ++i) part(i, c) = ordered(front->border[at(i)], c);
      }
      cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, own, columns, border, -1.0, front->factor.data() + own, size,
                  part.data(), border, 1.0, mine, n);
    }
    cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, own, columns, 1.0, front->factor.data(),
                size, mine, n);
  }
  for (int c = 0; c < columns; ++c) {
    for (std::size_t i = 0; i < new_of_old_.size(); ++i)
      x(static_cast<Eigen::Index>(i), c) = ordered(new_of_old_[i], c);
  }
}

double SparseCholesky::entries() const {
  double sum = 0.0;
  for (const Front& front : fronts_) sum += static_cast<double>(front.factor.size());
  return sum;
}

}  // namespace quoin
