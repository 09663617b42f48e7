#include "cosiva/base/json_parse_count.h"

namespace cosiva {
namespace {

thread_local std::uint64_t parsed = 0;

}  // namespace

std::uint64_t json_parse_count() { return parsed; }

void count_json_parse() { ++parsed; }

}  // namespace cosiva
