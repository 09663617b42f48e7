#include "virtual/server/traces.h"

#include <algorithm>
#include <cmath>

#include "base/json_writer.h"

namespace cosiva::virtual_side {
namespace {

/// Cuts before a byte that would split a UTF-8 character.
std::string_view cut(std::string_view text, std::size_t bytes_max) {
  if (text.size() <= bytes_max) return text;
  std::size_t end = bytes_max;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end);
}

double rounded(double value) { return std::nearbyint(value * 1000.0) / 1000.0; }

std::string text_of(const Pose2& pose, double speed_mps) {
  JsonWriter json;
  json.begin_object()
      .field("x", rounded(pose.x_m))
      .field("y", rounded(pose.y_m))
      .field("theta", rounded(pose.heading_rad))
      .field("speed", rounded(speed_mps))
      .end_object();
  return json.take();
}

}  // namespace

Traces::Traces(std::size_t capacity) : capacity_{std::max<std::size_t>(capacity, 1)} {}

Traces::Trace& Traces::slot(SimTime at, std::string_view from, std::string_view to, std::string_view kind) {
  const auto index = static_cast<std::size_t>((next_ - 1) % capacity_);
  if (index == ring_.size()) ring_.emplace_back();
  ++next_;
  Trace& trace = ring_[index];
  trace.at = at;
  trace.from.assign(from);
  trace.to.assign(to);
  trace.kind.assign(kind);
  return trace;
}

void Traces::add(SimTime at, std::string_view from, std::string_view to, std::string_view kind,
                 std::string_view content) {
  Trace& trace = slot(at, from, to, kind);
  trace.content.assign(cut(content, content_max));
  trace.is_position = false;
}

void Traces::add_position(SimTime at, std::string_view from, std::string_view to, std::string_view kind,
                          const Pose2& pose, double speed_mps) {
  Trace& trace = slot(at, from, to, kind);
  trace.is_position = true;
  trace.pose = pose;
  trace.speed_mps = speed_mps;
}

std::string Traces::to_json(std::uint64_t after, std::size_t limit) const {
  const std::uint64_t oldest = next_ - std::min<std::uint64_t>(next_ - 1, ring_.size());
  const std::uint64_t begin = std::clamp(after, oldest, next_);
  const std::uint64_t end = begin + std::min<std::uint64_t>(next_ - begin, limit);
  JsonWriter json;
  json.begin_object().field("next", end).key("traces").begin_array();
  for (std::uint64_t n = begin; n < end; ++n) {
    const Trace& trace = ring_[static_cast<std::size_t>((n - 1) % capacity_)];
    json.begin_object()
        .field("n", n)
        .field("time", to_iso8601(trace.at))
        .field("from", trace.from)
        .field("to", trace.to)
        .field("kind", trace.kind)
        .field("content", trace.is_position ? text_of(trace.pose, trace.speed_mps) : trace.content)
        .end_object();
  }
  json.end_array().end_object();
  return json.take();
}

}  // namespace cosiva::virtual_side
