#include "cosiva/zone/lif/json_fault.h"

#include <charconv>
#include <cmath>
#include <vector>

namespace cosiva::zone::lif {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Scans the text once, without recursion.
class Scanner {
 public:
  Scanner(std::string_view text, std::size_t depth_max) : text_{text}, depth_max_{depth_max} {}

  std::optional<JsonFault> run() {
    while (what_.empty() && step()) {
    }
    if (what_.empty()) return std::nullopt;
    std::size_t line = 1;
    std::size_t line_start = 0;
    for (std::size_t i = 0; i < at_ && i < text_.size(); ++i) {
      if (text_[i] != '\n') continue;
      ++line;
      line_start = i + 1;
    }
    return JsonFault{line, at_ - line_start + 1, what_};
  }

 private:
  enum class Want { value, value_or_end, key, key_or_end, colon, comma_or_end, nothing };

  [[nodiscard]] bool ended() const { return at_ >= text_.size(); }
  [[nodiscard]] char here() const { return ended() ? '\0' : text_[at_]; }

  /// False at the end of the text.
  bool step() {
    while (!ended() && (here() == ' ' || here() == '\t' || here() == '\n' || here() == '\r')) ++at_;
    if (ended()) {
      if (want_ != Want::nothing) what_ = std::string("the text ends here, where ") + expected() + " is missing";
      return false;
    }
    switch (want_) {
      case Want::nothing: what_ = "expected nothing more after the document's end"; break;
      case Want::colon: take(':', Want::value); break;
      case Want::key:
      case Want::key_or_end:
        if (here() == '"')
          string(Want::colon);
        else if (here() == '}' && want_ == Want::key_or_end)
          close();
        else
          report_error();
        break;
      case Want::comma_or_end:
        if (here() == ',') {
          ++at_;
          want_ = open_.back() == '{' ? Want::key : Want::value;
        } else if (here() == (open_.back() == '{' ? '}' : ']')) {
          close();
        } else {
          report_error();
        }
        break;
      case Want::value:
      case Want::value_or_end: value(); break;
    }
    return what_.empty();
  }

  [[nodiscard]] std::string expected() const {
    switch (want_) {
      case Want::value: return "a value";
      case Want::value_or_end: return "a value or ']'";
      case Want::key: return "a name in quotes";
      case Want::key_or_end: return "a name in quotes or '}'";
      case Want::colon: return "':'";
      case Want::comma_or_end: return open_.back() == '{' ? "',' or '}'" : "',' or ']'";
      case Want::nothing: break;
    }
    return "nothing";
  }

  void report_error() {
    what_ = "expected " + expected() + ", found ";
    if (here() >= ' ' && here() <= '~')
      what_ += std::string("'") + here() + "'";
    else
      what_ += "no character that is allowed here";
  }

  void take(char c, Want then) {
    if (here() != c) return report_error();
    ++at_;
    want_ = then;
  }

  void done() { want_ = open_.empty() ? Want::nothing : Want::comma_or_end; }

  void close() {
    ++at_;
    open_.pop_back();
    done();
  }

  void value() {
    if (here() == '{' || here() == '[') {
      if (open_.size() >= depth_max_) {
        what_ = "nested deeper than " + std::to_string(depth_max_);
        return;
      }
      open_.push_back(here());
      want_ = here() == '{' ? Want::key_or_end : Want::value_or_end;
      ++at_;
    } else if (here() == ']' && want_ == Want::value_or_end) {
      close();
    } else if (here() == '"') {
      string(Want::nothing);
      done();
    } else if (here() == '-' || is_digit(here())) {
      number();
    } else {
      for (const std::string_view word : {"true", "false", "null"}) {
        if (!text_.substr(at_).starts_with(word)) continue;
        at_ += word.size();
        return done();
      }
      report_error();
    }
  }

  void string(Want then) {
    const std::size_t begin = at_++;
    while (what_.empty()) {
      if (ended()) {
        at_ = begin;
        what_ = "a text in quotes that never ends";
      } else if (here() == '"') {
        ++at_;
        break;
      } else if (here() == '\\') {
        escape();
      } else if (static_cast<unsigned char>(here()) < 0x20) {
        what_ = "a line break or control character within a text in quotes";
      } else if (!character()) {
        what_ = "bytes that are not UTF-8; save the file as UTF-8";
      }
    }
    want_ = then;
  }

  void escape() {
    const std::string_view rest = text_.substr(at_);
    if (rest.size() >= 2 && std::string_view("\"\\/bfnrt").find(rest[1]) != std::string_view::npos) {
      at_ += 2;
      return;
    }
    const bool unicode = rest.size() >= 6 && rest[1] == 'u' &&
                         rest.substr(2, 4).find_first_not_of("0123456789abcdefABCDEF") == std::string_view::npos;
    if (unicode)
      at_ += 6;
    else
      what_ = "a backslash that begins no escape";
  }

  /// One character in UTF-8.
  bool character() {
    const auto first = static_cast<unsigned char>(here());
    const std::size_t more = first < 0x80U ? 0 : first >= 0xF0U ? 3 : first >= 0xE0U ? 2 : 1;
    if (first >= 0x80U && (first < 0xC2U || first > 0xF4U)) return false;
    if (at_ + more >= text_.size()) return false;
    for (std::size_t i = 1; i <= more; ++i) {
      if ((static_cast<unsigned char>(text_[at_ + i]) & 0xC0U) != 0x80U) return false;
    }
    at_ += more + 1;
    return true;
  }

  void number() {
    const std::size_t begin = at_;
    const auto digits = [this] {
      const std::size_t from = at_;
      while (is_digit(here())) ++at_;
      return at_ > from;
    };
    if (here() == '-') ++at_;
    const bool zero = here() == '0';
    const std::size_t whole = at_;
    bool good = digits() && !(zero && at_ - whole > 1);
    if (good && here() == '.') {
      ++at_;
      good = digits();
    }
    if (good && (here() == 'e' || here() == 'E')) {
      ++at_;
      if (here() == '+' || here() == '-') ++at_;
      good = digits();
    }
    if (!good) {
      at_ = begin;
      what_ = "no valid JSON number";
      return;
    }
    double read = 0.0;
    const std::string_view number = text_.substr(begin, at_ - begin);
    const std::size_t exponent = number.find_first_of("eE");
    // A number that is too small is 0.
    const bool large = exponent != std::string_view::npos && number[exponent + 1] != '-';
    if (large && std::from_chars(number.data(), number.data() + number.size(), read).ec != std::errc{}) {
      at_ = begin;
      what_ = "a number that is too large";
      return;
    }
    done();
  }

  std::string_view text_;
  std::size_t depth_max_;
  std::size_t at_{0};
  Want want_{Want::value};
  std::vector<char> open_;
  std::string what_;
};

}  // namespace

std::optional<JsonFault> find_json_fault(std::string_view text, std::size_t depth_max) {
  return Scanner{text, depth_max}.run();
}

}  // namespace cosiva::zone::lif
