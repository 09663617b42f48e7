#include "cosiva/hmi/call_context.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::app {

CallContext::CallContext(PageHost host) : host_{std::move(host)} {
  COSIVA_EXPECT(host_.core != nullptr && host_.command);
}

Result<void> CallContext::give(std::string json) {
  auto decoded = std::make_shared<const virtual_side::DecodedCommand>(json);
  if (host_.core->was_given(*decoded)) return {};
  if (auto checked = host_.core->check_command(*decoded); !checked) return checked;
  give_unchecked(std::move(json), std::move(decoded));
  return {};
}

void CallContext::give_unchecked(std::string json, std::shared_ptr<const virtual_side::DecodedCommand> decoded) {
  ++undecided_;
  host_.command("http", std::move(json), std::move(decoded), [this](const Result<void>& kept) {
    COSIVA_EXPECT(undecided_ > 0);
    --undecided_;
    if (!kept) failure_ = kept.error();
    if (undecided_ == 0 && on_decided_) on_decided_();
  });
}

PageHost::Clock CallContext::clock() const { return host_.clock ? host_.clock() : PageHost::Clock{}; }

void CallContext::know_plant(std::set<std::string> obstacles) {
  std::erase_if(plant_added_, [&](const std::string& id) { return obstacles.contains(id); });
  plant_obstacles_ = std::move(obstacles);
}

bool CallContext::in_plant(const std::string& obstacle) const {
  return plant_added_.contains(obstacle) || (plant_obstacles_ && plant_obstacles_->contains(obstacle));
}

std::string CallContext::next_obstacle_id() {
  std::string id;
  do id = "box" + std::to_string(++boxes_);
  while (in_plant(id));
  return id;
}

void CallContext::added_to_plant(const std::string& obstacle) { plant_added_.insert(obstacle); }

void CallContext::removed_from_plant(const std::string& obstacle) {
  if (plant_obstacles_) plant_obstacles_->erase(obstacle);
  plant_added_.erase(obstacle);
}

}  // namespace cosiva::app
