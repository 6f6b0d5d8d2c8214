// Formulas of path files: closed forms written as text beside the expected answer, and evaluated.
#pragma once

#include <map>
#include <memory>
#include <string>

namespace quoin {

using Variables = std::map<std::string, double>;

// Numbers, names, + - * / ^, parentheses, < > <= >= (1 or 0), if(condition, a, b), and functions. These are sqrt exp
// log sin cos tan atan atan2 abs min max hypot deg (degrees to radians); `pi` is known.
class Formula {
 public:
  Formula() = default;
  // Throws std::invalid_argument saying what is wrong and where.
  explicit Formula(const std::string& text);
  // Throws std::invalid_argument for a name that is not among the variables.
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
