#include "law/formula.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

namespace quoin {

struct Formula::Node {
  enum class Kind { number, name, call } kind = Kind::number;
  double number = 0.0;
  std::string name;  // name of a variable, operator or function
  std::vector<std::shared_ptr<const Node>> arguments;
};

namespace {

using Node = Formula::Node;
using NodePointer = std::shared_ptr<const Node>;

struct Function {
  const char* name;
  std::size_t arguments;
  double (*value)(const double*);
};

constexpr Function kFunctions[] = {
    {"+", 2, [](const double* a) { return a[0] + a[1]; }},
    {"-", 2, [](const double* a) { return a[0] - a[1]; }},
    {"*", 2, [](const double* a) { return a[0] * a[1]; }},
    {"/", 2, [](const double* a) { return a[0] / a[1]; }},
    {"^", 2, [](const double* a) { return std::pow(a[0], a[1]); }},
    {"neg", 1, [](const double* a) { return -a[0]; }},
    {"<", 2, [](const double* a) { return a[0] < a[1] ? 1.0 : 0.0; }},
    {">", 2, [](const double* a) { return a[0] > a[1] ? 1.0 : 0.0; }},
    {"<=", 2, [](const double* a) { return a[0] <= a[1] ? 1.0 : 0.0; }},
    {">=", 2, [](const double* a) { return a[0] >= a[1] ? 1.0 : 0.0; }},
    {"if", 3, [](const double* a) { return a[0] != 0.0 ? a[1] : a[2]; }},
    {"sqrt", 1, [](const double* a) { return std::sqrt(a[0]); }},
    {"exp", 1, [](const double* a) { return std::exp(a[0]); }},
    {"log", 1, [](const double* a) { return std::log(a[0]); }},
    {"sin", 1, [](const double* a) { return std::sin(a[0]); }},
    {"cos", 1, [](const double* a) { return std::cos(a[0]); }},
    {"tan", 1, [](const double* a) { return std::tan(a[0]); }},
    {"atan", 1, [](const double* a) { return std::atan(a[0]); }},
    {"atan2", 2, [](const double* a) { return std::atan2(a[0], a[1]); }},
    {"abs", 1, [](const double* a) { return std::abs(a[0]); }},
    {"min", 2, [](const double* a) { return std::min(a[0], a[1]); }},
    {"max", 2, [](const double* a) { return std::max(a[0], a[1]); }},
    {"hypot", 2, [](const double* a) { return std::hypot(a[0], a[1]); }},
    {"deg", 1, [](const double* a) { return a[0] * std::numbers::pi / 180.0; }},
};

const Function* find_function(const std::string& name) {
  for (const Function& function : kFunctions) {
    if (name == function.name) return &function;
  }
  return nullptr;
}

std::string shortened(const std::string& text) { return text.size() > 200 ? text.substr(0, 200) + "..." : text; }

// Recursive descent: comparison < sum < product < sign < power < atom.
class Parser {
 public:
  explicit Parser(const std::string& text) : text_(text) {}

  NodePointer whole() {
    // Long sums are deep trees too.
    if (text_.size() > kLongest)
      throw std::invalid_argument(
          fmt::format("formula '{}...': {} characters; at most {}", text_.substr(0, 40), text_.size(), kLongest));
    NodePointer result = comparison();
    skip();
    if (at_ != text_.size()) fail("unexpected text");
    return result;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::invalid_argument(
        fmt::format("formula '{}': {} at '{}'", shortened(text_), what, shortened(text_.substr(at_))));
  }
  void skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  bool take(const std::string& token) {
    skip();
    if (text_.compare(at_, token.size(), token) != 0) return false;
    at_ += token.size();
    return true;
  }
  static NodePointer call(std::string name, std::vector<NodePointer> arguments) {
    return std::make_shared<Node>(Node{Node::Kind::call, 0.0, std::move(name), std::move(arguments)});
  }
  // Counts the nesting of parentheses, signs and powers. A deeper formula is an error, and would exhaust the stack.
  class Deeper {
   public:
    explicit Deeper(Parser& parser) : depth_(parser.depth_) {
      if (++depth_ > kDeepest) parser.fail(fmt::format("nested more than {} deep", kDeepest));
    }
    ~Deeper() { --depth_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;

   private:
    int& depth_;
  };
  NodePointer comparison() {
    NodePointer left = sum();
    for (const char* token : {"<=", ">=", "<", ">"}) {
      if (take(token)) return call(token, {left, sum()});
    }
    return left;
  }
  NodePointer sum() {
    NodePointer left = product();
    for (;;) {
      if (take("+")) {
        left = call("+", {left, product()});
      } else if (take("-")) {
        left = call("-", {left, product()});
      } else {
        return left;
      }
    }
  }
  NodePointer product() {
    NodePointer left = sign();
    for (;;) {
      if (take("*")) {
        left = call("*", {left, sign()});
      } else if (take("/")) {
        left = call("/", {left, sign()});
      } else {
        return left;
      }
    }
  }
  NodePointer sign() {
    const Deeper deeper(*this);
    if (take("-")) return call("neg", {sign()});
    if (take("+")) return sign();
    NodePointer base = atom();
    if (take("^")) return call("^", {base, sign()});
    return base;
  }
  NodePointer atom() {
    skip();
    if (take("(")) {
      NodePointer inside = comparison();
      if (!take(")")) fail("')' is missing");
      return inside;
    }
    if (at_ >= text_.size()) fail("the end comes too early");
    const char first = text_[at_];
    if (std::isdigit(static_cast<unsigned char>(first)) != 0 || first == '.') {
      double value = 0.0;
      const auto [end, fault] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
      if (fault != std::errc()) fail("no number");
      at_ = static_cast<std::size_t>(end - text_.data());
      return std::make_shared<Node>(Node{Node::Kind::number, value, {}, {}});
    }
    std::size_t end = at_;
    while (end < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[end])) != 0 || text_[end] == '_'))
      ++end;
    if (end == at_) fail("no number, name or '('");
    std::string name = text_.substr(at_, end - at_);
    at_ = end;
    if (!take("(")) return std::make_shared<Node>(Node{Node::Kind::name, 0.0, std::move(name), {}});
    std::vector<NodePointer> arguments{comparison()};
    while (take(",")) arguments.push_back(comparison());
    if (!take(")")) fail("')' is missing");
    const Function* function = find_function(name);
    if (function == nullptr) fail(fmt::format("no function '{}'", name));
    if (function->arguments != arguments.size())
      fail(fmt::format("'{}' takes {} arguments", name, function->arguments));
    return call(std::move(name), std::move(arguments));
  }

  static constexpr int kDeepest = 200;
  static constexpr std::size_t kLongest = 10000;  // characters
  const std::string& text_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

double evaluate(const Node& node, const Variables& variables) {
  if (node.kind == Node::Kind::number) return node.number;
  if (node.kind == Node::Kind::name) {
    const auto found = variables.find(node.name);
    if (found != variables.end()) return found->second;
    if (node.name == "pi") return std::numbers::pi;
    throw std::invalid_argument(fmt::format("nothing is called '{}' here", node.name));
  }
  double values[3] = {};
  for (std::size_t i = 0; i < node.arguments.size(); ++i) values[i] = evaluate(*node.arguments[i], variables);
  return find_function(node.name)->value(values);
}

bool mentions(const Node& node, const std::string& name) {
  if (node.kind == Node::Kind::name) return node.name == name;
  return std::any_of(node.arguments.begin(), node.arguments.end(), [&](const auto& a) { return mentions(*a, name); });
}

}  // namespace

Formula::Formula(const std::string& text) : text_(text) { root_ = Parser(text_).whole(); }

double Formula::operator()(const Variables& variables) const { return evaluate(*root_, variables); }

bool Formula::uses(const std::string& name) const { return root_ != nullptr && mentions(*root_, name); }

}  // namespace quoin
