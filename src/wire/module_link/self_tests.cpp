#include "cosiva/wire/module_link/self_tests.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::wire::module_link {
namespace {

bool has_passed(const PartFinding& part) { return part.finding == Finding::passed; }

}  // namespace

SelfTestRequest SelfTests::begin(SimTime now, std::vector<Board> boards) {
  boards_ = std::move(boards);
  parts_ = {};
  since_.reset();
  if (!complete()) since_ = now;
  return {++number_};
}

void SelfTests::on_result(Board board, const SelfTestResult& result) {
  if (!open() || result.number != number_) return;
  parts_[index(board)] = result.parts;
  if (complete()) since_.reset();
  COSIVA_EXPECT(!open() || !complete());
}

void SelfTests::on_tick(SimTime now) {
  if (since_ && now - *since_ > duration_max) since_.reset();
}

bool SelfTests::complete() const {
  return std::ranges::all_of(boards_, [&](Board board) { return parts(board).has_value(); });
}

bool SelfTests::passed() const {
  return std::ranges::all_of(
      boards_, [&](Board board) { return parts(board).has_value() && std::ranges::all_of(*parts(board), has_passed); });
}

std::string SelfTests::text() const {
  std::string text;
  for (const Board board : boards_) {
    text += (text.empty() ? "" : ", ") + std::string(to_string(board));
    if (!parts(board)) {
      text += " no response";
    } else if (std::ranges::all_of(*parts(board), has_passed)) {
      text += " passed";
    } else {
      for (const PartFinding& part : *parts(board))
        if (!has_passed(part)) text += " " + fault_text(fault_code(part));
    }
  }
  return text;
}

void SelfTests::archive(Archive& archive) { archive(number_, since_, boards_, parts_); }

}  // namespace cosiva::wire::module_link
