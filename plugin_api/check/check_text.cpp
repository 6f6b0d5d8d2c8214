// C2: texts that a law writes into buffers of its caller.
#include <algorithm>
#include <cstring>

#include "checks.h"

namespace check {
namespace {

constexpr char kGuard = 0x5a;
constexpr uint64_t kNotWritten = 12345;  // bytes, no message is of this length

using Call = std::function<bool(quoin_text*)>;

// C2.2 and C2.3 with a buffer of this capacity, between guards that the whole message does not pass.
void check_capacity(Report& report, const char* what, const Call& call, const std::string& message, size_t capacity) {
  constexpr size_t kMargin = 8192;
  std::vector<char> bytes(capacity + 2 * kMargin, kGuard);
  const auto begin = bytes.begin() + kMargin, end = begin + static_cast<long>(capacity);
  quoin_text text = {sizeof text, &*begin, capacity, kNotWritten};
  call(&text);
  report.clause("C2.2");
  const auto guarded = [](char c) { return c == kGuard; };
  report.expect(std::all_of(bytes.begin(), begin, guarded) && std::all_of(end, bytes.end(), guarded),
                "%s: bytes outside a buffer of %zu were written", what, capacity);
  if (capacity > 0) {
    const auto zero = std::find(begin, end, '\0');
    if (report.expect(zero != end, "%s: no final zero in a buffer of %zu", what, capacity)) {
      report.expect(message.starts_with(std::string(begin, zero)),
                    "%s: a cut message is not the beginning of the whole one", what);
    }
  }
  report.clause("C2.3");
  report.expect(text.length == message.size(), "%s: length %llu with capacity %zu for a message of %zu bytes", what,
                static_cast<unsigned long long>(text.length), capacity, message.size());
}

}  // namespace

void check_text(Report& report, const char* what, const Call& call) {
  report.clause("C2.1");
  Text whole;
  call(&whole.text);
  const std::string message = whole.str();
  report.expect(call(nullptr), "%s: another result with null text", what);
  quoin_text nowhere = {sizeof nowhere, nullptr, 0, kNotWritten};
  report.expect(call(&nowhere), "%s: another result with null data", what);

  report.clause("C2.3");
  for (const quoin_text* text : {&whole.text, &nowhere}) {
    report.expect(text->length == message.size(), "%s: length %llu%s for a message of %zu bytes", what,
                  static_cast<unsigned long long>(text->length), text == &nowhere ? " with null data" : "",
                  message.size());
  }
  for (const size_t capacity : {0u, 1u, 2u, 3u, 7u, 8u, 31u, 40u, 64u, 100u, 200u}) {
    check_capacity(report, what, call, message, capacity);
  }

  report.clause("C2.4");
  char small[64];
  std::fill(std::begin(small), std::end(small), kGuard);
  quoin_text cut = {24, small, sizeof small, kNotWritten};
  call(&cut);
  report.expect(cut.length == kNotWritten && small[0] == kGuard, "%s: a quoin_text of 24 bytes was written to", what);
}

}  // namespace check
