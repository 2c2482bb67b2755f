#include "config/text_limits.hpp"

#include <fmt/format.h>

#include "bulkley/config/toml.hpp"

namespace bulkley::config {
namespace {

constexpr int deepest_brackets = 32;
constexpr int most_dots = 16;  ///< of one key: each is a table within a table

/// Goes through a text without understanding more of it than where strings and comments end.
class Scan {
 public:
  explicit Scan(const std::string& text) : text_(text) {}

  std::optional<TextFault> fault() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"' || c == '\'')
        skip_string(c);
      else if (c == '#')
        skip_to_line_end();
      else
        take(c);
      if (depth_ > deepest_brackets)
        return here(fmt::format("brackets are nested more than {} deep here", deepest_brackets));
      if (dots_ > most_dots) return here(fmt::format("a key has more than {} parts with dots between them", most_dots));
      if (n_values_ > most_values) return here(fmt::format("the text holds more than {} values", most_values));
    }
    return std::nullopt;
  }

 private:
  void take(char c) {
    if (c == '.') ++dots_;
    if (c == '[' || c == '{') ++depth_;
    if ((c == ']' || c == '}') && depth_ > 0) --depth_;
    if (c == '[' || c == '{' || c == ',' || c == '=') ++n_values_;
    if (c == ',' || c == '=' || c == '[' || c == ']' || c == '{' || c == '}' || c == '\n') dots_ = 0;
    if (c == '\n') {
      ++line_;
      line_start_ = at_ + 1;
    }
    ++at_;
  }

  void skip_to_line_end() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  }

  /// Past the quote that ends the string, or to the end of the line or text that cuts it off.
  void skip_string(char quote) {
    const bool is_long = text_.compare(at_, 3, std::string(3, quote)) == 0;
    const std::string end(is_long ? 3 : 1, quote);
    at_ += end.size();
    while (at_ < text_.size()) {
      if (text_.compare(at_, end.size(), end) == 0) {
        at_ += end.size();
        return;
      }
      if (text_[at_] == '\n') {
        if (!is_long) return;
        ++line_;
        line_start_ = at_ + 1;
      }
      const bool is_escape = quote == '"' && text_[at_] == '\\' && at_ + 1 < text_.size() && text_[at_ + 1] != '\n';
      at_ += is_escape ? 2 : 1;
    }
  }

  TextFault here(const std::string& sentence) const { return {line_, static_cast<int>(at_ - line_start_), sentence}; }

  const std::string& text_;
  std::size_t at_ = 0, line_start_ = 0;
  int line_ = 1, depth_ = 0, dots_ = 0;
  std::size_t n_values_ = 0;
};

}  // namespace

std::optional<TextFault> size_fault(const std::string& text) {
  if (text.size() > largest_text) return TextFault{0, 0, fmt::format("the text is larger than {} MiB", largest_text >> 20)};
  return Scan(text).fault();
}

}  // namespace bulkley::config
