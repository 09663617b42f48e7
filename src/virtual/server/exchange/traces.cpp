#include "cosiva/virtual/server/exchange/traces.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"

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

std::string metres_text(double m) {
  std::array<char, 32> text{};
  const double shown = rounded(std::clamp(m, -1e9, 1e9));  // fits the text for any reported value
  const auto end = std::to_chars(text.data(), text.data() + text.size(), shown, std::chars_format::fixed, 3);
  return {text.data(), end.ptr};
}

Traces::Traces(std::size_t capacity, std::size_t raw_budget)
    : capacity_{std::max<std::size_t>(capacity, 1)}, raw_budget_{raw_budget} {}

Traces::Trace& Traces::slot(SimTime at, std::string_view from, std::string_view to, std::string_view kind,
                            std::string_view topic, std::string_view raw, Hop hop) {
  const auto index = static_cast<std::size_t>((next_ - 1) % capacity_);
  if (index == buffer_.size()) buffer_.emplace_back();
  ++next_;
  COSIVA_EXPECT(buffer_.size() == std::min<std::uint64_t>(next_ - 1, capacity_));
  Trace& trace = buffer_[index];
  trace.at = at;
  trace.from.assign(from);
  trace.to.assign(to);
  trace.hop = hop;
  trace.kind.assign(kind);
  trace.topic.assign(topic);
  keep(trace, raw);
  return trace;
}

void Traces::add(SimTime at, std::string_view from, std::string_view to, std::string_view kind,
                 std::string_view content, std::string_view topic, std::string_view raw, Hop hop) {
  Trace& trace = slot(at, from, to, kind, topic, raw, hop);
  trace.content.assign(cut(content, content_max));
  trace.is_position = false;
}

void Traces::add_position(SimTime at, std::string_view from, std::string_view to, std::string_view kind,
                          const Pose2& pose, double speed_mps, std::string_view topic, std::string_view raw, Hop hop) {
  Trace& trace = slot(at, from, to, kind, topic, raw, hop);
  trace.is_position = true;
  trace.pose = pose;
  trace.speed_mps = speed_mps;
}

void Traces::keep(Trace& trace, std::string_view raw) {
  trace.raw_begin = raw_end_;
  trace.raw_size = raw.size() > std::min(raw_max, raw_budget_) ? 0 : raw.size();
  if (trace.raw_size == 0) return;
  raw_end_ += raw.size();
  if (raw_buffer_.size() < raw_budget_) {
    const auto needed = static_cast<std::size_t>(std::min<std::uint64_t>(raw_end_, raw_budget_));
    if (needed > raw_buffer_.capacity()) raw_buffer_.reserve(std::min(raw_budget_, std::max(needed, raw_max) * 2));
    raw_buffer_.resize(std::max(needed, raw_buffer_.size()));
    COSIVA_EXPECT(raw_buffer_.size() <= raw_budget_);
  }
  const auto begin = static_cast<std::size_t>(trace.raw_begin % raw_budget_);
  const std::size_t before_the_end = std::min(raw.size(), raw_budget_ - begin);
  raw.copy(raw_buffer_.data() + begin, before_the_end);
  raw.substr(before_the_end).copy(raw_buffer_.data(), raw.size() - before_the_end);
}

std::optional<std::string> Traces::raw_of(const Trace& trace) const {
  if (trace.raw_size == 0 || raw_end_ - trace.raw_begin > raw_budget_) return std::nullopt;
  const auto begin = static_cast<std::size_t>(trace.raw_begin % raw_budget_);
  const std::size_t before_the_end = std::min(trace.raw_size, raw_budget_ - begin);
  std::string raw{raw_buffer_.data() + begin, before_the_end};
  return raw.append(raw_buffer_.data(), trace.raw_size - before_the_end);
}

const Traces::Trace& Traces::at(std::uint64_t n) const {
  return buffer_[static_cast<std::size_t>((n - 1) % capacity_)];
}

std::uint64_t Traces::oldest() const { return next_ - buffer_.size(); }

void Traces::write_head(JsonWriter& json, std::uint64_t n, const Trace& trace) {
  json.field("n", n).field("time_ms", to_milliseconds_scaled(trace.at)).field("from", trace.from).field("to", trace.to);
  if (trace.hop != Hop::none)
    json.field("via", "proxy of " + (trace.hop == Hop::proxy_of_sender ? trace.from : trace.to));
  json.field("kind", trace.kind);
}

std::string Traces::content_of(const Trace& trace) {
  return trace.is_position ? text_of(trace.pose, trace.speed_mps) : trace.content;
}

std::string Traces::to_json(std::uint64_t after, std::size_t limit) const {
  const std::uint64_t begin = std::clamp(after, oldest(), next_);
  const std::uint64_t end = begin + std::min<std::uint64_t>(next_ - begin, limit);
  JsonWriter json;
  json.begin_object().field("next", end).field("oldest", oldest()).key("traces").begin_array();
  for (std::uint64_t n = begin; n < end; ++n) {
    const Trace& trace = at(n);
    write_head(json.begin_object(), n, trace);
    json.field("content", content_of(trace)).end_object();
  }
  json.end_array().end_object();
  return json.take();
}

std::optional<std::string> Traces::one_json(std::uint64_t n) const {
  if (n < oldest() || n >= next_) return std::nullopt;
  const Trace& trace = at(n);
  const auto raw = raw_of(trace);
  JsonWriter json;
  write_head(json.begin_object(), n, trace);
  json.field("topic", trace.topic).field("content", content_of(trace)).key("raw");
  raw ? json.value(*raw) : json.null();
  json.end_object();
  return json.take();
}

void Traces::archive(Archive& archive) { archive(buffer_, next_, raw_buffer_, raw_end_); }

}  // namespace cosiva::virtual_side
