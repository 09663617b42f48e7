#include "cosiva/virtual/simulator/augmented.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::virtual_side {

std::string_view to_string(VirtualObjectKind kind) { return kind == VirtualObjectKind::person ? "person" : "obstacle"; }

std::optional<VirtualObjectKind> parse_virtual_object_kind(std::string_view word) {
  if (word == "person") return VirtualObjectKind::person;
  if (word == "obstacle") return VirtualObjectKind::obstacle;
  return std::nullopt;
}

std::string_view to_string(Repeat repeat) {
  switch (repeat) {
    case Repeat::once: return "once";
    case Repeat::back_and_forth: return "back and forth";
    case Repeat::loop: return "loop";
  }
  return "?";
}

std::optional<Repeat> parse_repeat(std::string_view word) {
  for (const Repeat repeat : {Repeat::once, Repeat::back_and_forth, Repeat::loop})
    if (to_string(repeat) == word) return repeat;
  return std::nullopt;
}

Walk::Walk(std::vector<Point2> path, double speed_mps, Repeat repeat)
    : path_{std::move(path)}, speed_mps_{speed_mps}, repeat_{repeat} {
  COSIVA_EXPECT(!path_.empty() && path_.size() <= points_max && speed_mps >= 0.0);
  reached_m_.clear();
  reached_m_.push_back(0.0);
  for (std::size_t i = 1; i < path_.size(); ++i)
    reached_m_.push_back(reached_m_.back() + distance(path_[i - 1], path_[i]));
  if (repeat_ == Repeat::loop && path_.size() > 1)
    reached_m_.push_back(reached_m_.back() + distance(path_.back(), path_.front()));
  length_m_ = reached_m_.back();
}

Walk::Motion Walk::at(SimDuration since_start) const {
  if (!walks()) return {path_.front(), 0.0, 0.0, 0.0};
  double s_m = speed_mps_ * std::max(0.0, to_seconds(since_start));
  bool back = false;
  bool is_stopped = false;
  switch (repeat_) {
    case Repeat::once:
      is_stopped = s_m >= length_m_;
      s_m = std::min(s_m, length_m_);
      break;
    case Repeat::loop: s_m -= std::floor(s_m / length_m_) * length_m_; break;
    case Repeat::back_and_forth:
      s_m -= std::floor(s_m / (2.0 * length_m_)) * 2.0 * length_m_;
      back = s_m > length_m_;
      if (back) s_m = 2.0 * length_m_ - s_m;
      break;
  }
  s_m = std::max(s_m, 0.0);  // subtracting whole rounds may leave a tiny negative number
  // The leg that ends beyond s. A leg of length zero is never chosen, since both its ends have the same distance.
  auto end = std::ranges::upper_bound(reached_m_, s_m);
  if (end == reached_m_.end()) end = std::ranges::lower_bound(reached_m_, length_m_);
  const auto leg = static_cast<std::size_t>(end - reached_m_.begin());
  const Point2 from = path_[leg - 1];
  const Point2 to = path_[leg % path_.size()];
  const double leg_m = reached_m_[leg] - reached_m_[leg - 1];
  const double ratio = std::clamp((s_m - reached_m_[leg - 1]) / leg_m, 0.0, 1.0);
  const double sign = back ? -1.0 : 1.0;
  const double ux = sign * (to.x_m - from.x_m) / leg_m;
  const double uy = sign * (to.y_m - from.y_m) / leg_m;
  const double speed = is_stopped ? 0.0 : speed_mps_;
  return {{from.x_m + ratio * (to.x_m - from.x_m), from.y_m + ratio * (to.y_m - from.y_m)},
          det_atan2(uy, ux),
          speed * ux,
          speed * uy};
}

const VirtualObject& Augmented::add(VirtualObject virtual_object) {
  COSIVA_EXPECT(find(virtual_object.id) == nullptr && virtual_objects_.size() < virtual_objects_max);
  // Handles are assigned cyclically, so that a page does not confuse a new object with a removed one.
  const auto used = [&](std::uint16_t handle) {
    return std::ranges::find(virtual_objects_, handle, &VirtualObject::handle) != virtual_objects_.end();
  };
  do {
    virtual_object.handle = static_cast<std::uint16_t>(first_handle + next_);
    next_ = static_cast<std::uint16_t>((next_ + 1) % handles);
  } while (used(virtual_object.handle));
  virtual_objects_.push_back(std::move(virtual_object));
  return virtual_objects_.back();
}

bool Augmented::move(std::string_view id, Walk walk, SimTime now) {
  const auto it = std::ranges::find(virtual_objects_, id, &VirtualObject::id);
  if (it == virtual_objects_.end()) return false;
  it->walk = std::move(walk);
  it->started = now;
  return true;
}

bool Augmented::remove(std::string_view id) {
  return std::erase_if(virtual_objects_,
                       [id](const VirtualObject& virtual_object) { return virtual_object.id == id; }) > 0;
}

const VirtualObject* Augmented::find(std::string_view id) const {
  const auto it = std::ranges::find(virtual_objects_, id, &VirtualObject::id);
  return it == virtual_objects_.end() ? nullptr : &*it;
}

void Augmented::fold(Digest& digest) const {
  for (const VirtualObject& virtual_object : virtual_objects_) {
    digest.add(std::string_view{virtual_object.id});
    digest.add(static_cast<std::uint64_t>(virtual_object.kind));
    digest.add(std::uint64_t{virtual_object.handle});
    digest.add(virtual_object.radius_m);
    digest.add(virtual_object.started);
    digest.add(virtual_object.walk.speed_mps());
    digest.add(static_cast<std::uint64_t>(virtual_object.walk.repeat()));
    for (const Point2 point : virtual_object.walk.path()) {
      digest.add(point.x_m);
      digest.add(point.y_m);
    }
  }
}

void Walk::archive(Archive& archive) { archive(path_, speed_mps_, repeat_, reached_m_, length_m_); }

void Augmented::archive(Archive& archive) { archive(virtual_objects_, next_); }

}  // namespace cosiva::virtual_side
