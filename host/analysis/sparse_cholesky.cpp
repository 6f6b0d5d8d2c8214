#include "analysis/sparse_cholesky.h"

#include <cblas.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <numeric>
#include <thread>

#include "base/error.h"

// LAPACK's, as OpenBLAS has it.
extern "C" void dpotrf_(const char* triangle, const int* n, double* a, const int* lda, int* info);

namespace quoin {
namespace {

using Eigen::MatrixXd;
using geometry::Vector;
using Matrix = Eigen::SparseMatrix<double>;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Unknowns from which on a part of the masonry is cut no further: a front of that size is quick, and a small one is
// mostly overhead.
constexpr int kLeaf = 200;

// Groups that share an entry of the matrix, row by row.
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

// Cuts the masonry in two, again and again, and numbers the unknowns of each part before those of the cut.
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
  // Returns the fronts that nothing below has as children yet.
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

  // Along the longest axis, where places leave a gap that is nearest to the middle of the list.
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

  // Takes out of one side what touches the other: of that side where it has fewer unknowns.
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

SparseCholesky::SparseCholesky(const Matrix& lower, const UnknownGroups& groups, int threads)
    : pool_(
          std::make_unique<ThreadPool>(threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency()))) {
  {
    Dissection dissection(lower, groups);
    new_of_old_ = std::move(dissection.new_of_old), fronts_ = std::move(dissection.fronts);
  }
  const Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order(
      Eigen::Map<const Eigen::VectorXi>(new_of_old_.data(), lower.rows()));
  Matrix permuted(lower.rows(), lower.cols());
  permuted.selfadjointView<Eigen::Lower>() = lower.selfadjointView<Eigen::Lower>().twistedBy(order);
  find_borders(permuted);
  divide();
  factorize(permuted);
}

void SparseCholesky::find_borders(const Matrix& permuted) {
  std::size_t entries = 0;
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
    front.at = entries;
    entries += at(front.own) * at(front.size());
  }
  factor_ = LaneVector<double>(entries);
  // Gigabytes in small pages take as long to get as to fill.
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  auto* const begin = reinterpret_cast<unsigned char*>(factor_.data());
  const std::size_t skipped = (page - reinterpret_cast<std::uintptr_t>(begin) % page) % page;
  const std::size_t bytes = entries * sizeof(double);
  if (bytes > skipped + page) madvise(begin + skipped, (bytes - skipped) / page * page, MADV_HUGEPAGE);
}

// Subtrees of about equal work, several for each thread. Fronts of one are in a row.
void SparseCholesky::divide() {
  constexpr int kPerThread = 8;
  std::vector<int> first(fronts_.size());
  std::vector<double> work(fronts_.size());
  std::vector<bool> has_parent(fronts_.size(), false);
  for (std::size_t k = 0; k < fronts_.size(); ++k) {
    const Front& front = fronts_[k];
    const auto size = static_cast<double>(front.size());
    first[k] = static_cast<int>(k), work[k] = front.own * size * size;
    for (const int child : front.children) {
      first[k] = std::min(first[k], first[at(child)]), work[k] += work[at(child)];
      has_parent[at(child)] = true;
    }
  }
  const auto less_work = [&](int a, int b) { return work[at(a)] < work[at(b)]; };
  std::vector<int> roots;
  for (std::size_t k = 0; k < fronts_.size(); ++k) {
    if (!has_parent[k]) roots.push_back(static_cast<int>(k));
  }
  const auto wanted = at(kPerThread * pool_->thread_count());
  while (pool_->thread_count() > 1 && !roots.empty() && roots.size() < wanted) {
    const auto most = std::max_element(roots.begin(), roots.end(), less_work);
    const int front = *most;
    if (fronts_[at(front)].children.empty()) break;
    roots.erase(most), top_.push_back(front);
    roots.insert(roots.end(), fronts_[at(front)].children.begin(), fronts_[at(front)].children.end());
  }
  std::sort(top_.begin(), top_.end());
  std::sort(roots.begin(), roots.end(), [&](int a, int b) { return less_work(b, a); });
  for (const int root : roots) subtrees_.push_back({first[at(root)], root + 1});
}

// visit(thread, front): children before parents, or after them.
template <class Visit>
void SparseCholesky::each_front(bool upwards, const Visit& visit) const {
  std::vector<std::exception_ptr> failed(at(pool_->thread_count()));
  auto of_subtree = [&](int thread, int subtree) {
    const auto [first, end] = subtrees_[at(subtree)];
    try {
      for (int k = 0; k < end - first; ++k) visit(thread, upwards ? first + k : end - 1 - k);
    } catch (...) {
      failed[at(thread)] = std::current_exception();
    }
  };
  const auto all_subtrees = [&] {
    // All are the first thread's, from whom the others take.
    const std::vector<int> end(at(pool_->thread_count()), static_cast<int>(subtrees_.size()));
    pool_->for_each(end, of_subtree);
    for (const std::exception_ptr& thrown : failed) {
      if (thrown) std::rethrow_exception(thrown);
    }
  };
  if (upwards) all_subtrees();
  for (std::size_t k = 0; k < top_.size(); ++k) visit(0, upwards ? top_[k] : top_[top_.size() - 1 - k]);
  if (!upwards) all_subtrees();
}

void SparseCholesky::factorize(const Matrix& permuted) {
  std::vector<MatrixXd> update(fronts_.size());  // what a front leaves to its parent, lower triangle
  std::vector<Scratch> scratch(at(pool_->thread_count()));
  for (Scratch& of_thread : scratch) of_thread.place.resize(new_of_old_.size());
  each_front(true, [&](int thread, int front) { form(front, permuted, update, scratch[at(thread)]); });
}

void SparseCholesky::form(int index, const Matrix& permuted, std::vector<MatrixXd>& update, Scratch& scratch) {
  const Front& front = fronts_[at(index)];
  const int size = front.size();
  std::vector<int>& place = scratch.place;
  for (int i = 0; i < front.own; ++i) place[at(front.first + i)] = i;
  for (int i = front.own; i < size; ++i) place[at(front.border[at(i - front.own)])] = i;
  scratch.full.assign(at(size) * at(size), 0.0);
  Eigen::Map<MatrixXd> full(scratch.full.data(), size, size);
  for (int column = 0; column < front.own; ++column) {
    for (Matrix::InnerIterator entry(permuted, front.first + column); entry; ++entry) {
      const int i = place[static_cast<std::size_t>(entry.row())];
      full(std::max(i, column), std::min(i, column)) += entry.value();
    }
  }
  for (const int child : front.children) {
    const std::vector<int>& rows = fronts_[at(child)].border;
    MatrixXd& from = update[at(child)];
    for (std::size_t j = 0; j < rows.size(); ++j) {
      double* const column = scratch.full.data() + at(size) * at(place[at(rows[j])]);
      const double* const given = from.data() + j * rows.size();
      for (std::size_t i = j; i < rows.size(); ++i) column[place[at(rows[i])]] += given[i];
    }
    from.resize(0, 0);
  }
  eliminate(front, scratch.full);
  std::copy_n(scratch.full.begin(), at(size) * at(front.own), factor_.begin() + static_cast<std::ptrdiff_t>(front.at));
  update[at(index)] = full.bottomRightCorner(size - front.own, size - front.own);
}

void SparseCholesky::eliminate(const Front& front, std::vector<double>& full) const {
  const int own = front.own, size = front.size(), border = size - own;
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
  MatrixXd ordered(x.rows(), x.cols());
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    for (Eigen::Index i = 0; i < x.rows(); ++i) ordered(new_of_old_[static_cast<std::size_t>(i)], c) = x(i, c);
  }
  std::vector<MatrixXd> update(fronts_.size());
  each_front(true, [&](int, int front) { forward(front, ordered, update); });
  std::vector<MatrixXd> part(at(pool_->thread_count()));
  each_front(false, [&](int thread, int front) { backward(front, ordered, part[at(thread)]); });
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    for (Eigen::Index i = 0; i < x.rows(); ++i) x(i, c) = ordered(new_of_old_[static_cast<std::size_t>(i)], c);
  }
}

// What a front adds to later unknowns goes up from front to front, so that no two threads write to one place.
void SparseCholesky::forward(int index, MatrixXd& x, std::vector<MatrixXd>& update) const {
  const Front& front = fronts_[at(index)];
  const auto columns = static_cast<int>(x.cols()), rows = static_cast<int>(x.rows());
  const int own = front.own, size = front.size(), border = size - own, end = front.first + own;
  MatrixXd& mine = update[at(index)];
  mine = MatrixXd::Zero(border, columns);
  for (const int child : front.children) {
    MatrixXd& from = update[at(child)];
    const std::vector<int>& given = fronts_[at(child)].border;
    // Both are ascending.
    std::size_t place = 0;
    for (std::size_t i = 0; i < given.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      if (given[i] < end) {
        x.row(given[i]) += from.row(row);
        continue;
      }
      while (front.border[place] != given[i]) ++place;
      mine.row(static_cast<Eigen::Index>(place)) += from.row(row);
    }
    from.resize(0, 0);
  }
  const double* const factor = factor_.data() + front.at;
  double* const values = x.data() + front.first;
  cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, own, columns, 1.0, factor, size, values,
              rows);
  if (border == 0) return;
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, border, columns, own, -1.0, factor + own, size, values, rows,
              1.0, mine.data(), border);
}

void SparseCholesky::backward(int index, MatrixXd& x, MatrixXd& part) const {
  const Front& front = fronts_[at(index)];
  const auto columns = static_cast<int>(x.cols()), rows = static_cast<int>(x.rows());
  const int own = front.own, size = front.size(), border = size - own;
  const double* const factor = factor_.data() + front.at;
  double* const values = x.data() + front.first;
  if (border > 0) {
    part.resize(border, columns);
    for (int c = 0; c < columns; ++c) {
      for (int i = 0; i < border; ++i) part(i, c) = x(front.border[at(i)], c);
    }
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, own, columns, border, -1.0, factor + own, size, part.data(),
                border, 1.0, values, rows);
  }
  cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, own, columns, 1.0, factor, size, values,
              rows);
}

}  // namespace quoin
