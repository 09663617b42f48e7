#include "cosiva/physical/plant/obstacles.h"

#include <algorithm>
#include <charconv>
#include <functional>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::physical {
namespace {

std::string shortest(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}
std::string text(Point2 p) {
  char buffer[96];
  char* end = std::to_chars(buffer, buffer + 40, p.x_m, std::chars_format::fixed, 2).ptr;
  *end++ = ',';
  *end++ = ' ';
  end = std::to_chars(end, end + 40, p.y_m, std::chars_format::fixed, 2).ptr;
  return "(" + std::string(buffer, end) + ")";
}

zone::Bounds world_of(const zone::TrafficZone& zone) {
  zone::Bounds world = zone::bounds(zone::draw(zone));
  world.low = {world.low.x_m - Obstacles::off_world_m, world.low.y_m - Obstacles::off_world_m};
  world.high = {world.high.x_m + Obstacles::off_world_m, world.high.y_m + Obstacles::off_world_m};
  return world;
}

Error refused(std::string message, const std::string& id) { return {"plant.command", std::move(message), id}; }

}  // namespace

Obstacles::Obstacles(const zone::TrafficZone& zone) : shape_{zone.vehicle}, world_{world_of(zone)} {}

void Obstacles::set_zone(const zone::TrafficZone& zone) { world_ = world_of(zone); }

std::optional<Error> Obstacles::add(const JsonValue& given, std::span<const BodyPose> bodies) {
  const auto id = given.text("id");
  if (!id || id->empty() || id->size() > 64) return refused("give the obstacle an 'id' of 1 to 64 bytes", {});
  const auto x = given.number("x");
  const auto y = given.number("y");
  if (!x || !y) return refused("give the obstacle's position, as 'x' and 'y' in metres", *id);
  const auto radius = given.number("radius");
  if (!radius) return refused("give the obstacle's size, as 'radius' in metres", *id);
  const Disc disc{{*x, *y}, *radius};
  if (auto error = check(*id, disc, bodies)) return error;

  const auto at = std::lower_bound(all_.begin(), all_.end(), *id,
                                   [](const Obstacle& o, const std::string& name) { return o.id < name; });
  if (at != all_.end() && at->id == *id) {
    at->disc = disc;  // moved
  } else {
    if (all_.size() >= count_max) return refused("there are 1000 obstacles already; remove one first", *id);
    all_.insert(at, Obstacle{*id, disc, next_key_++});
  }
  record_discs();
  return std::nullopt;
}

std::optional<Error> Obstacles::check(const std::string& id, const Disc& disc, std::span<const BodyPose> bodies) const {
  // Written so that a NaN is refused.
  if (!(disc.radius_m >= radius_m_min && disc.radius_m <= radius_m_max))
    return refused("give a 'radius' from 0.01 m to 2 m, not " + shortest(disc.radius_m) + " m", id);
  if (!(disc.centre.x_m >= world_.low.x_m && disc.centre.x_m <= world_.high.x_m && disc.centre.y_m >= world_.low.y_m &&
        disc.centre.y_m <= world_.high.y_m))
    return refused("this position is off the floor, which reaches from " + text(world_.low) + " to " +
                       text(world_.high) + " m; choose one inside",
                   id);
  const auto hit =
      std::find_if(bodies.begin(), bodies.end(), [&](const BodyPose& body) { return touch(body, disc, shape_); });
  if (hit == bodies.end()) return std::nullopt;
  return refused("AIV" + std::to_string(hit - bodies.begin() + 1) +
                     " is at this position; put the obstacle next to it, or wait until it has left",
                 id);
}

std::optional<Error> Obstacles::remove(std::string_view id) {
  if (std::erase_if(all_, [&](const Obstacle& o) { return o.id == id; }) == 0) {
    std::string known;
    for (std::size_t i = 0; i < std::min<std::size_t>(all_.size(), 5); ++i) known += (i == 0 ? "" : ", ") + all_[i].id;
    return refused("there is no obstacle of this name to remove; " +
                       (known.empty() ? std::string("there is none at all")
                                      : "there " + std::string(all_.size() == 1 ? "is " : "are ") + known +
                                            (all_.size() > 5 ? ", …" : "")),
                   std::string(id.substr(0, 64)));
  }
  record_discs();
  return std::nullopt;
}

std::string Obstacles::name_of(CollisionWatch::BodyKey key) const {
  const auto found = std::find_if(all_.begin(), all_.end(), [&](const Obstacle& o) { return o.key == key; });
  return found == all_.end() ? "obstacle" : found->id;
}

void Obstacles::archive(Archive& archive) {
  archive(all_, next_key_);
  if (archive.reads()) record_discs();
}

void Obstacles::record_discs() {
  COSIVA_EXPECT(all_.size() <= count_max);
  COSIVA_EXPECT(std::ranges::adjacent_find(all_, std::ranges::greater_equal{}, &Obstacle::id) == all_.end());
  discs_.clear();
  for (const Obstacle& obstacle : all_) discs_.push_back({obstacle.key, obstacle.disc});
}

}  // namespace cosiva::physical
