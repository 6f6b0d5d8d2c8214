// Formulas of path files: closed forms as text, and their evaluation.
#pragma once

#include <map>
#include <memory>
#include <string>

namespace quoin {

using Variables = std::map<std::string, double>;

// Numbers, names, + - * / ^, parentheses, < > <= >= (1 or 0), if(condition, a, b), and functions. These are sqrt exp
// log sin cos tan atan atan2 abs min max hypot deg (degrees to radians). `pi` is a constant.
class Formula {
 public:
  Formula() = default;
  // Throws std::invalid_argument with the error and its place.
  explicit Formula(const std::string& text);
  // Value of the formula. Throws std::invalid_argument for a name that is not among the variables.
  double operator()(const Variables& variables) const;
  bool uses(const std::string& name) const;
  const std::string& text() const { return text_; }
  bool empty() const { return root_ == nullptr; }

  struct Node;

 private:
  std::string text_;
  std::shared_ptr<const Node> root_;
};

}  // namespace quoin
